// SPDX-License-Identifier: MIT
#include "app/boat/alone.hpp"

#include <algorithm>
#include <tuple>

#include "app/convert/convert_scalar.hpp"
#include "app/operator/telemetry/sentences.hpp"

namespace flotilla::app {
namespace {

constexpr bool kSailsVoyages = FLOTILLA_SAILS_VOYAGES != 0;
// The microcontroller's image has no room for it: there each target begins from rest.
constexpr bool kChangesTargets = FLOTILLA_KEEPS_FLEET != 0;

}  // namespace

template <class S>
void Alone<S>::start(const Now& now) {
  driven_ = false;
  guidance_.start_alone();
  if (now.state == core::State::kAuto) {
    start_plan(now.now_us);
  } else {
    start_errand(now, true);
  }
}

template <class S>
core::ControllerOutput<S> Alone<S>::sail(const Now& now, S dt) {
  if (now.state == core::State::kAuto) return sail_plan(now, dt);
  if (now.state == core::State::kGuided) return sail_guided(now, dt);
  keep_fence(now);
  return guidance_.sail(errands_.plan(), vehicle_.orders().is_paused(), now.now_us, dt);
}

template <class S>
void Alone<S>::check_way(const convert::Position& here, std::int64_t now_us) {
  if (!way_due_.take_if_due(now_us)) return;
  vehicle_.missions().check_way(here, configuration().plan);
}

template <class S>
void Alone<S>::start_plan(std::int64_t now_us) {
  MissionService& missions = vehicle_.missions();
  missions.begin_round();
  voyage_.begin_plan({missions.round(), missions.current(), missions.progress().jumps()});
  guidance_.start_plan({.plan = missions.plan(),
                        .first = missions.current(),
                        .start_m = missions.start_m(missions.current()),
                        .home = home(),
                        .progress = missions.progress(),
                        .pauses = missions.pauses(),
                        .voyage_is_over = voyage_.is_over(),
                        .fence = &missions.fence()},
                       configuration().plan);
  guidance_.reports().forget_waits(now_us);
  warnings_.forget_waiting();
}

/// anew: the state begins; otherwise the vessel that the boat follows sails on, if it is near.
template <class S>
void Alone<S>::start_errand(const Now& now, bool anew) {
  voyage_.interrupt();
  const std::optional<Target> asked = vehicle_.orders().take_target();
  const bool at_fence = (now.conditions & core::kInsideFence) == 0;  // no room to stop ahead
  const bool goes_on = kChangesTargets && !anew && !at_fence && guidance_.is_near_vessel();
  const Target here =
      at_fence ? Target{convert::global_of(guidance_.place())} : guidance_.stop_ahead(goes_on);
  lost_s_ = 0;
  asked_ = now.state == core::State::kGuided ? asked : std::nullopt;
  if (now.state == core::State::kReturn) return sail_back(here);
  errands_.sail_to(asked_.value_or(here));
  if (!goes_on) return sail_errand();
  guidance_.change_plan(errand(), configuration().plan);
}

template <class S>
void Alone<S>::sail_back(const Target& meanwhile) {
  const auto home = this->home();
  if (!home) return sail_round(meanwhile, meanwhile);
  sail_round({return_place(guidance_.place(), *home)}, meanwhile);
}

template <class S>
convert::GlobalPoint Alone<S>::return_place(const convert::Position& here,
                                            const convert::GlobalPoint& home) const {
  const auto& [plan, failsafes] = std::tie(configuration().plan, configuration().failsafes);
  return vehicle_.missions().return_place(here, home, plan, failsafes.fence_m);
}

template <class S>
void Alone<S>::sail_round(const Target& target, const Target& meanwhile) {
  errands_.sail_round(vehicle_.missions().fence(), guidance_.place(), target, meanwhile,
                      configuration().plan.margin_m);
  tell_way();
  sail_errand();
}

template <class S>
void Alone<S>::sail_errand() {
  guidance_.start_plan(errand(), configuration().plan);
}

/// Continues the search for a way round the forbidden zones; begins it again when the fence has
/// changed and, in RTL or with a target, after 10 s without a way. Checks the present leg once a
/// second, because the boat may be pushed aside.
template <class S>
void Alone<S>::keep_fence(const Now& now) {
  constexpr std::uint8_t kAgain_s = 10;
  const Fence& fence = vehicle_.missions().fence();
  const bool returns = now.state == core::State::kReturn;
  const auto sail_anew = [&] {
    const Target here{convert::global_of(guidance_.place())};
    returns ? sail_back(here) : sail_round(asked_.value_or(here), here);
  };
  if (errands_.is_outdated(fence)) return returns ? look_again() : sail_anew();
  const bool found = errands_.look_for_way(fence);
  tell_way();
  if (found) sail_errand();
  if (!leg_due_.take_if_due(now.now_us)) return;
  const bool goes = returns || asked_;
  if (goes && errands_.is_lost() && lost_s_++ == kAgain_s) return look_again();
  if (fence.is_on() && !leg_keeps_fence()) sail_anew();
}

/// In RTL or with a target, while the boat waits: looks for a way again.
template <class S>
void Alone<S>::look_again() {
  const auto home = this->home();
  if (!asked_ && !home) return;
  const convert::Position here = guidance_.place();
  const Target goal = asked_ ? *asked_ : Target{return_place(here, *home)};
  const Fence& fence = vehicle_.missions().fence();
  if (errands_.look_again(fence, here, goal, configuration().plan.margin_m)) {
    lost_s_ = 0;
    sail_errand();
  }
  tell_way();
}

/// Whether the straight ways from the boat to the vessel that sails the errand, and to that
/// vessel's next place, respect the fence.
template <class S>
bool Alone<S>::leg_keeps_fence() const {
  const PlanVessel<S>& sailed = guidance_.plan_vessel();
  const auto ahead = place_of(errands_.plan()[sailed.item()]);
  return is_free(convert::global_of(sailed.place())) && (!ahead || is_free(*ahead));
}

/// Whether the straight way to `ahead` respects the fence. Outside the fence, any way may lead
/// back.
template <class S>
bool Alone<S>::is_free(const convert::GlobalPoint& ahead) const {
  constexpr Fence::Length kNone{0};
  const Fence& fence = vehicle_.missions().fence();
  const auto from = fence.on_map(guidance_.place()), to = fence.on_map(ahead);
  if (!from || !to || !(kNone < fence.clearance(*from))) return true;
  return kNone < fence.clearance(*from, *to);
}

template <class S>
void Alone<S>::tell_way() {
  const std::string_view news = errands_.take_news();
  const bool lost = errands_.is_lost();
  if (!news.empty() && !(lost && lost_s_ > 0)) warnings_.warn(news);
  if (!news.empty()) lost_s_ = lost ? 1 : 0;
}

/// Changes the speed at which the boat sails to its target; 0: WP_SPEED.
template <class S>
void Alone<S>::change_speed(float speed_mps) {
  const PlanDefaults& plan = configuration().plan;
  const float asked_mps = speed_mps > 0 ? speed_mps : plan.speed_mps;
  const float most_mps = plan.fastest_mps > 0 ? plan.fastest_mps : asked_mps;
  errands_.set_speed(speed_mps);
  guidance_.set_speed(convert::scalar<S>(std::min(asked_mps, most_mps)));
}

template <class S>
core::ControllerOutput<S> Alone<S>::sail_guided(const Now& now, S dt) {
  const auto drive = vehicle_.orders().drive(now.now_us);
  const std::optional<Target>& target = vehicle_.orders().target();
  // A repeated target must not restart the vessel that the boat follows.
  if (target && !driven_ && errands_.leads_to(target->place)) {
    asked_ = vehicle_.orders().take_target();
    change_speed(asked_->speed_mps);
  }
  if (target || (driven_ && !drive)) start_errand(now, false);
  driven_ = drive.has_value();
  if (!drive) keep_fence(now);
  const bool paused = vehicle_.orders().is_paused();
  return drive ? guidance_.drive(convert::drive_of<S>(*drive), paused, now.now_us, dt)
               : guidance_.sail(errands_.plan(), paused, now.now_us, dt);
}

template <class S>
core::ControllerOutput<S> Alone<S>::sail_plan(const Now& now, S dt) {
  if (vehicle_.missions().take_item_set()) {
    if (kSailsVoyages && voyage_.is_on()) guidance_.start_alone();
    start_plan(now.now_us);
  }
  const core::ControllerOutput<S> out = sail_items(now, dt);
  PlanVessel<S>& sailed = guidance_.plan_vessel();
  auto reached = sailed.reached();
  if (kSailsVoyages && !reached && voyage_.is_over()) reached = voyage_.item();
  vehicle_.report_progress(sailed.ahead(), reached, sailed.has_arrived(), counters_);
  if (sailed.take_pause()) pause_plan(now.now_us);
  if (const auto set = sailed.take_home()) {
    const auto place = home_of(vehicle_.missions().plan()[*set]);
    limits_.set_home(place ? *place : convert::global_of(guidance_.place()));
  }
  return out;
}

template <class S>
void Alone<S>::pause_plan(std::int64_t now_us) {
  vehicle_.orders().pause(true, now_us);
  Sentence told;
  told << "Plan paused after item "
       << static_cast<float>(guidance_.plan_vessel().reached().value_or(0))
       << ": autocontinue is 0";
  vehicle_.texts().send(link::mav::kSeverityInfo, {told.text()}, counters_);
}

/// Sails the plan's items by the law, except a voyage that measures the hull.
template <class S>
core::ControllerOutput<S> Alone<S>::sail_items(const Now& now, S dt) {
  const MissionService& missions = vehicle_.missions();
  if (kSailsVoyages && !voyage_.is_on()) {
    const PlanMark at = guidance_.plan_vessel().ahead();
    voyage_.begin(missions.plan()[at.item], {missions.round(), at.item, at.jumps}, guidance_,
                  configuration());
  }
  if (kSailsVoyages && voyage_.is_on()) return sail_voyage(now, dt);
  // While the fleet's shape moves, the leader waits for nobody: behind a leader at rest, some slots
  // would move astern.
  const bool paused = vehicle_.orders().is_paused(), waits = !paused && !now.shape_moves;
  if (!waits) guidance_.reports().forget_waits(now.now_us);
  const auto late = waits ? guidance_.reports().late(now.now_us) : std::nullopt;
  warnings_.tell_waiting(late);
  return guidance_.sail(missions.plan(), paused || late, now.now_us, dt);
}

template <class S>
core::ControllerOutput<S> Alone<S>::sail_voyage(const Now& now, S dt) {
  const MissionService& missions = vehicle_.missions();
  const PlanItem& centre = missions.plan()[voyage_.item()];
  if (way_due_.take_if_due(now.now_us)) {
    const auto& [plan, failsafes] = std::tie(configuration().plan, configuration().failsafes);
    voyage_.look(guidance_, {missions.fence(), plan.margin_m, home(), failsafes.fence_m},
                 speeds_of(plan), now.now_us);
  }
  const bool waits = vehicle_.orders().is_paused() || (now.conditions & core::kClear) == 0;
  core::ControllerOutput<S> out;
  out.allocation.thrust = voyage_.forward(guidance_, {centre.x, centre.y}, waits, now.now_us, dt);
  if (const auto news = voyage_.take_news()) {
    const bool lost = news->kind == VoyageNews::Kind::kLost;
    vehicle_.texts().send(lost ? link::mav::kSeverityError : link::mav::kSeverityInfo,
                          {sentence_of(*news).text()}, counters_);
  }
  if (voyage_.is_over()) {
    guidance_.start_alone();
    start_plan(now.now_us);
  }
  return out;
}

template <class S>
void Alone<S>::look_for_rally(const convert::Position& here, std::int64_t now_us) {
  const auto home = this->home();
  if (limits_.home_near() || !home) rally_near_ = false;
  if (limits_.home_near() || !home || !rally_due_.take_if_due(now_us)) return;
  const auto goal = return_place(here, *home);
  rally_near_ = convert::distance_m(here, {0, 0, {goal.latitude, goal.longitude, 0, 0}}) <
                double{kErrandReach_m};
}

template <class S>
std::optional<convert::GlobalPoint> Alone<S>::home() const {
  const auto home = limits_.home();
  if (!home) return std::nullopt;
  return convert::GlobalPoint{home->latitude, home->longitude};
}

template class Alone<float>;
template class Alone<double>;
template class Alone<core::Q16>;

}  // namespace flotilla::app
