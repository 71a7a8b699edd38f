// SPDX-License-Identifier: MIT
#include "app/boat.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <tuple>
#include <utility>

#include "app/convert/portable.hpp"
#include "app/operator/text.hpp"
#include "app/parameters/derived.hpp"
#include "core/manual.hpp"
#include "core/scalar/overflow.hpp"

namespace flotilla::app {
namespace {

constexpr bool kKeepsFleet = FLOTILLA_KEEPS_FLEET != 0;
constexpr std::int64_t kSecond_us = 1'000'000;
// Followers keep the formation's reference through a COAST of their leader shorter than this.
constexpr std::int64_t kShortCoast_us = 1'000'000;
// 285 years: fits 64 bits even in ns, and lies beyond any real clock.
constexpr std::int64_t kLatest_us = 9'000'000'000'000'000;

float hundredths(std::int64_t n) { return static_cast<float>(n) / 100; }

/// The nearest 1/n, of a number under 1000.
float to_nearest(float x, int n) {
  const float scaled = static_cast<float>(n) * x;
  return static_cast<float>(static_cast<int>(scaled + (x < 0 ? -0.5F : 0.5F))) /
         static_cast<float>(n);
}

/// "10:31", UTC; "minute 12" of the boat's clock where the time of day at its 0 is unknown, 0.
void put_time(Sentence& out, std::int64_t at_us, std::int64_t unix_us_at_0) {
  constexpr std::int64_t kMinute_us = 60'000'000;
  constexpr std::uint32_t kHour = 60, kDay = 24;
  const auto minutes = static_cast<std::uint32_t>((unix_us_at_0 + at_us) / kMinute_us);
  if (unix_us_at_0 == 0) {
    out << "minute " << static_cast<float>(minutes);
    return;
  }
  const std::uint32_t hour = minutes / kHour % kDay, minute = minutes % kHour;
  out << (hour < 10 ? "0" : "") << static_cast<float>(hour) << (minute < 10 ? ":0" : ":")
      << static_cast<float>(minute);
}

/// "slot needs 2.13 m/s, LAW_U_MAX is 1.5"; rounded up, so that the figure exceeds the limit.
Sentence slot_needs(double needed, std::string_view limit_is, float limit) {
  Sentence out;
  out << "slot needs " << hundredths(portable::ceil(100 * needed)) << limit_is << limit;
  return out;
}

}  // namespace

template <class S>
Boat<S>::Boat(const Parameters& p, std::size_t links, const Storage& storage)
    : can_output_(storage.can),
      links_(Identity(configuration_of(p).start).self(), storage.links.first(links),
             storage.mavlink, storage.signing),
      pilot_(configuration_of(p), convert::law_of<S>(p)),
      vehicle_(p, supervisor_, links_, pilot_.time_requests(), storage),
      tick_rate_Hz_(p.CTL_RATE),
      thrusters_(configuration().propulsion, convert::law_of<S>(p)),
      can_({configuration().start.can_node, configuration().start.system},
           configuration().start.tick_us / 2),
      way_due_(kSecond_us / 10),
      fence_warning_due_(10 * kSecond_us),
      frame_warning_due_(10 * kSecond_us),
      fast_slot_warning_due_(10 * kSecond_us),
      unsound_slot_warning_due_(10 * kSecond_us),
      unsaved_warning_due_(30 * kSecond_us),
      closed_warning_due_(30 * kSecond_us),
      beaten_due_(10 * kSecond_us),
      double_due_(10 * kSecond_us),
      time_warning_due_(30 * kSecond_us),
      quality_due_(10 * kSecond_us),
      late_due_(10 * kSecond_us) {
  core::take_overflow<S>();
  configure();
}

template <class S>
std::int64_t Boat<S>::monotonic(std::int64_t now) {
  const std::int64_t now_us = std::clamp<std::int64_t>(now, 0, kLatest_us) + clock_shift_us_;
  if (now_us >= now_us_) {
    behind_since_us_.reset();
    now_us_ = std::min(now_us, kLatest_us);
    return now_us_;
  }
  ++counters_.clock_went_back;
  if (!behind_since_us_) behind_since_us_ = now_us;
  // The clock was set back and runs on from there: follow it.
  if (now_us - *behind_since_us_ > kSecond_us) clock_shift_us_ += now_us_ - now_us;
  return now_us_;
}

template <class S>
void Boat<S>::on_mavlink(std::span<const std::uint8_t> data, std::int64_t now, std::size_t link) {
  const std::int64_t now_us = monotonic(now);
  core::take_overflow<S>();
  while (!data.empty()) {
    data = data.subspan(links_.fill(link, data));
    take_all(link, now_us);
  }
  collect_overflow();
}

template <class S>
void Boat<S>::end_of_datagram(std::int64_t now, std::size_t link) {
  core::take_overflow<S>();
  give_up(link, monotonic(now));
  collect_overflow();
}

/// The overflow flag is shared by all boats of a thread, so each call clears it first and collects
/// it here.
template <class S>
void Boat<S>::collect_overflow() {
  overflow_ = core::take_overflow<S>() || overflow_;
}

template <class S>
void Boat<S>::take_all(std::size_t link, std::int64_t now_us) {
  while (links_.next(link, received_, now_us, counters_)) {
    if (kKeepsFleet && received_.from.system != vehicle_.self().system) {
      const auto commander = configuration().operators.commander;
      fleet_.hear(received_, !commander || *commander == received_.from.system, now_us);
    }
    const bool operators = vehicle_.take(link, received_, now_us, counters_);
    if (operators) continue;
    if (const auto* time = std::get_if<link::SystemTime>(&received_.message)) {
      learn_time(link, *time, now_us);
    } else {
      pilot_.take(received_, link, now_us, counters_);
    }
  }
}

/// Accepts the time only from the own system: signed, or on a link without signing (the unit's
/// cable).
template <class S>
void Boat<S>::learn_time(std::size_t link, const link::SystemTime& time, std::int64_t now_us) {
  if (received_.from.system != vehicle_.self().system) return;
  if (!received_.is_signed && links_.policy(link) != SigningPolicy::kOff) return;
  const auto unix_us =
      static_cast<std::int64_t>(std::min<std::uint64_t>(time.time_unix_usec, kLatest_us));
  if (link::signing_time(unix_us) == 0) return;
  learnt_unix_us_ = unix_us - now_us;
  set_clock();
}

template <class S>
void Boat<S>::set_clock() {
  const bool set = host_.clock_is_set && host_.unix_us > 0;
  if (!set && learnt_unix_us_) host_.unix_us = *learnt_unix_us_ + now_us_;
  if (host_.unix_us == 0) return;
  links_.signing().set_clock(link::signing_time(host_.unix_us), set || learnt_unix_us_);
}

/// The rest of an incomplete message will not come; the bytes behind its start may hold another
/// one.
template <class S>
void Boat<S>::give_up(std::size_t link, std::int64_t now_us) {
  while (links_.give_up(link, counters_)) take_all(link, now_us);
}

template <class S>
void Boat<S>::on_can(std::uint32_t can_id, std::span<const std::uint8_t> data, std::int64_t now) {
  can_.on_frame(can_id, data, monotonic(now), counters_);
}

template <class S>
typename Boat<S>::Output Boat<S>::tick(std::int64_t now) {
  const std::int64_t now_us = monotonic(now);
  core::take_overflow<S>();
  vehicle_.begin(now_us, last_tick_us_ ? now_us - *last_tick_us_ : 0);
  can_output_.count = 0;
  idle_ticks_ = last_tick_us_ == now_us ? idle_ticks_ + 1 : 0;
  for (std::size_t link = 0; link < links_.count(); ++link) {
    if (links_.waits_in_vain(link, now_us)) give_up(link, now_us);
  }
  collect_overflow();
  in_range_ = fits_ && !std::exchange(overflow_, false);
  if (last_tick_us_ && vehicle_.is_asked()) vehicle_.report(report(*last_tick_us_));
  supervise(now_us);
  steer(now_us);
  look_at_limits(now_us);
  can_.send(thrust_.raw, core::armed(state()), now_us, counters_, can_output_);
  send_warnings(now_us);
  tell(now_us);
  collect_overflow();
  last_tick_us_ = now_us;
  return {&links_, std::span(can_output_.frames).first(can_output_.count)};
}

template <class S>
void Boat<S>::supervise(std::int64_t now_us) {
  if (vehicle_.take_change()) configure();
  apply_conditions(now_us);
  if (kKeepsFleet) consult_fleet(now_us);
  if (host_.stop_pressed || can_.stop_pressed(now_us)) vehicle_.stop(counters_);
  bool more = true;
  while (more) {
    more = vehicle_.answer(counters_);
    note_state(now_us);
    if (!vehicle_.take_change()) continue;
    // A change applies before the next request is judged: a new leader, say, is not yet heard.
    configure();
    apply_conditions(now_us);
  }
  vehicle_.apply_rc(counters_);
  const bool follows = state() == core::State::kFormation || state() == core::State::kCoast;
  if (follows && configuration().formation.returns_alone &&
      pilot_.reports().leader_returns(now_us)) {
    vehicle_.request(core::Request::kReturn, counters_);
  }
  note_state(now_us);
}

/// What the fleet's rule asks for comes before the operators' requests of this tick, so theirs win.
template <class S>
void Boat<S>::consult_fleet(std::int64_t now_us) {
  const MissionService& missions = vehicle_.missions();
  const auto item = static_cast<std::uint16_t>(missions.current());
  const bool fit = (conditions_ & core::kLoiterBegins) == core::kLoiterBegins;
  const FleetOrder order =
      fleet_.step({vehicle_.self().system, state(), fit, {missions.id(Stored::kPlan), item}},
                  configuration().formation, configuration().navigation.leader_limit_us, now_us);
  if (fleet_.take_change()) {
    configure();
    apply_conditions(now_us);
  }
  switch (order) {
    case FleetOrder::kNone:
      return;
    case FleetOrder::kLead:
      lead_fleet();
      break;
    case FleetOrder::kFollow:
      vehicle_.obey(core::Request::kFormation, counters_);
      break;
    case FleetOrder::kStop:
      vehicle_.obey(core::Request::kHold, counters_);
      break;
  }
  note_state(now_us);
}

/// Sails on with the fleet's plan from where the last leader was, or waits if it has another one.
template <class S>
void Boat<S>::lead_fleet() {
  MissionService& missions = vehicle_.missions();
  const FleetPlace& place = fleet_.place();
  const bool shared = place.plan_id != 0 && place.plan_id == missions.id(Stored::kPlan);
  if (shared && missions.set_current(place.item) &&
      vehicle_.obey(core::Request::kAuto, counters_)) {
    return;
  }
  vehicle_.obey(core::Request::kLoiter, counters_);
}

template <class S>
void Boat<S>::tell_fleet(std::int64_t now_us) {
  if (const auto beacon = fleet_.beacon(now_us)) links_.broadcast(*beacon, counters_);
  if (const auto table = fleet_.table(now_us)) links_.broadcast(*table, counters_);
  if (const auto epoch = fleet_.take_epoch()) {
    Sentence text;
    text << "fleet table " << static_cast<float>(*epoch) << " is in force";
    vehicle_.send_statustext(link::mav::kSeverityInfo, {text.text()}, counters_);
  }
  if (const auto refused = fleet_.take_refusal()) {
    constexpr std::array<std::string_view, 6> kWhy{"",
                                                   "empty",
                                                   "listed twice: boat ",
                                                   "does not follow one above it: boat ",
                                                   "must lead and cannot: boat ",
                                                   "slots overlap: boats "};
    Sentence text;
    text << "Fleet table refused: " << kWhy[static_cast<std::size_t>(refused->fault)];
    if (refused->system != 0) text << static_cast<float>(refused->system);
    if (refused->other != 0) text << ", " << static_cast<float>(refused->other);
    warn(text.text());
  }
}

/// Called after each answered request, so that leaving FORMATION and returning within one tick
/// restarts the pilot.
template <class S>
void Boat<S>::note_state(std::int64_t now_us) {
  const core::State was = std::exchange(last_state_, state());
  if (was == core::State::kDisarmed && core::armed(state()) && !pilot_.own_quality().told() &&
      (conditions_ & core::kOwnFresh) != 0) {
    vehicle_.send_statustext(link::mav::kSeverityInfo,
                             {"navigation quality is not reported, not checked"}, counters_);
  }
  if (!core::sails_alone(state())) vehicle_.take_target();  // it came before another request
  if (was == state()) return;
  if (core::sails_alone(was)) pilot_.end_plan();
  if (core::sails_alone(state())) start_plan();
  if (state() != core::State::kFormation) return;
  if (was == core::State::kCoast) {
    pilot_.close_anew();
  } else {
    pilot_.start(now_us);
  }
}

/// Home, or a rally point; nothing if the straight way there leaves the fence: then a way round is
/// looked for, while the boat waits.
template <class S>
std::optional<Target> Boat<S>::way_back() {
  const auto home = limits_.home();
  if (!home) return std::nullopt;
  const MissionService& missions = vehicle_.missions();
  const convert::Position here = pilot_.place();
  const convert::GlobalPoint back =
      missions.return_place(here, {home->latitude, home->longitude}, configuration().plan);
  if (!missions.fence().is_on() || missions.fence().refusal_of(here, back, 0).empty()) {
    return Target{back};
  }
  way_round_.begin(missions.fence(), here, Target{back}, configuration().plan.margin_m);
  if (!way_round_.is_searching()) warn("no way back keeps the fence: the boat waits");
  return std::nullopt;
}

template <class S>
void Boat<S>::look_for_way() {
  if (!way_round_.is_searching()) return;
  const Fence& fence = vehicle_.missions().fence();
  way_round_.forward(fence);
  if (way_round_.is_searching()) return;
  if (!way_round_.found()) {
    warn("no way back keeps the fence: the boat waits");
    return;
  }
  warn("straight back leaves the fence: the boat sails round");
  errand_ = way_round_.errand(fence);
  pilot_.start_plan({errand_.plan(), 0, kErrandReach_m}, configuration().plan);
}

/// Begins AUTO, or the errand of GUIDED, LOITER or RTL.
template <class S>
void Boat<S>::start_plan() {
  voyage_.interrupt();
  if (state() == core::State::kAuto) {
    const MissionService& missions = vehicle_.missions();
    const bool goes_on = voyage_.is_of(missions.id(Stored::kPlan), missions.current());
    if (!goes_on || missions.is_complete()) voyage_.forget();
    const auto home = limits_.home();
    pilot_.start_plan(
        {.plan = missions.plan(),
         .first = missions.current(),
         .home = home ? std::optional(convert::GlobalPoint{home->latitude, home->longitude})
                      : std::nullopt},
        configuration().plan);
    reached_.reset();
    awaited_.reset();
    return;
  }
  way_round_.stop();
  const std::optional<Target> asked = vehicle_.take_target();
  const bool guided = state() == core::State::kGuided && asked;
  const auto back = state() == core::State::kReturn ? way_back() : std::nullopt;
  const bool at_fence = (conditions_ & core::kInsideFence) == 0;  // no room to stop ahead
  const Target here = at_fence ? Target{convert::global_of(pilot_.place())} : pilot_.stop_ahead();
  errand_.sail_to(guided ? *asked : back ? *back : here);
  pilot_.start_plan({errand_.plan(), 0, kErrandReach_m}, configuration().plan);
}

/// Does DO_SET_HOME where it follows the place that was reached.
template <class S>
void Boat<S>::set_home_of_plan(std::size_t reached) {
  const Plan plan = vehicle_.missions().plan();
  for (std::size_t i = reached + 1; i < plan.size() && !place_of(plan[i]); ++i) {
    if (plan[i].command != link::mav::kDoSetHome) continue;
    const auto place = home_of(plan[i]);
    limits_.set_home(place ? *place : convert::global_of(pilot_.place()));
  }
}

template <class S>
void Boat<S>::configure() {
  collect_overflow();
  max_idle_ticks_ = static_cast<int>(parameters().FS_NAV_S * tick_rate_Hz_);
  supervisor_.choose(configuration().failsafes.choices);
  const Parameters applied = kKeepsFleet ? fleet_.applied(parameters()) : parameters();
  const auto law = convert::law_of<S>(learnt_.applied(applied));
  learnt_.configure(applied, convert::in_float(law.controller.outer.r_max));
  pilot_.configure(configuration_of(applied), law, vehicle_.self().system);
  if (!core::armed(state())) thrusters_ = {configuration().propulsion, law};
  thrusters_.set_curves(law);
  fits_ = !core::take_overflow<S>();
  in_range_ = in_range_ && fits_;
}

template <class S>
void Boat<S>::apply_conditions(std::int64_t now_us) {
  heard_ = heard(now_us);
  conditions_ = conditions(now_us);
  vehicle_.apply_conditions(conditions_, counters_);
}

/// The conditions that depend on messages, frames, the host and parameters alone. Within a tick only
/// a change of parameters changes them; kClear moves with the boat, but is asked only before a tick's
/// motion.
template <class S>
core::Conditions Boat<S>::heard(std::int64_t now_us) const {
  static_assert(((core::kManualDrive | core::kDrive | core::kCoastDrive | core::kAutoDrive |
                  core::kGuidedDrive | core::kReturnDrive | core::kTestDrive) &
                 core::kClear) == 0);
  core::Conditions met = vehicle_.conditions(now_us) | pilot_.heard(now_us) |
                         propulsion_of(can_, configuration().propulsion, now_us);
  if (host_.bus_up) met |= core::kBusUp;
  if (host_.parameters_saved) met |= core::kParametersSaved;
  return met;
}

template <class S>
core::Conditions Boat<S>::conditions(std::int64_t now_us) const {
  // With a stopped clock no data ever become stale, so nothing can be trusted.
  if (idle_ticks_ > max_idle_ticks_) return 0;
  const bool sails = core::law_drives(state());
  core::Conditions met =
      heard_ | supervisor_.conditions(now_us) | pilot_.conditions(now_us) | limits_.conditions();
  if (coasts_on(now_us)) met |= core::kCoastRunning;
  if (in_range_) met |= core::kInRange;
  if (!slot_astern_.is() && pilot_.claims().is_free(pilot_.tree_place(), now_us, sails)) {
    met |= core::kSlotSound;
  }
  if ((pilot_.astray() == core::Astray::kNo && !voyage_.is_lost()) || !sails)
    met |= core::kOnStation;
  if (!fence_watch_.stays()) met &= ~core::kInsideFence;
  if (pilot_.located()) met |= core::kLocated;
  const MissionService& missions = vehicle_.missions();
  const bool reached = !core::sails_alone(state()) || pilot_.plan_vessel().is_sound();
  if (!reached) met &= ~core::kHomeNear;
  if (!missions.plan().empty() && pilot_.located() && reached &&
      missions.plan_keeps_fence(state() == core::State::kAuto)) {
    met |= core::kPlanReady;
  }
  if (vehicle_.doubled(now_us)) met &= ~core::kSoleVessel;
  if (sails && pilot_.leader_jumped()) met &= ~core::kLeaderSteady;  // until a new request
  return met;
}

template <class S>
bool Boat<S>::coasts_on(std::int64_t now_us) const {
  const auto since_us = supervisor_.coasting_since_us();
  if (!since_us) return true;
  return now_us - *since_us < configuration().failsafes.coast_us && pilot_.can_coast();
}

/// Called once this tick's position is known; the result enters the next tick's conditions.
template <class S>
void Boat<S>::look_at_limits(std::int64_t now_us) {
  const auto& [failsafes, propulsion] =
      std::tie(configuration().failsafes, configuration().propulsion);
  const bool armed = core::armed(state());
  const bool fenced = vehicle_.missions().fence().is_on();
  const bool placed = (fenced || limits_.asks_place(failsafes, armed, now_us)) &&
                      pilot_.located() && (conditions_ & core::kOwnFresh) != 0;
  const auto place = placed ? std::optional(pilot_.place()) : std::nullopt;
  limits_.look(failsafes, {now_us,
                           armed,
                           place,
                           {can_.esc_status(propulsion.port_esc, now_us),
                            can_.esc_status(propulsion.stbd_esc, now_us)}});
  look_at_fence(place, now_us);
}

template <class S>
void Boat<S>::look_at_fence(const std::optional<convert::Position>& place, std::int64_t now_us) {
  MissionService& missions = vehicle_.missions();
  FenceWatch::Seen seen{now_us, place, {}};
  if (place && missions.fence().is_on()) {
    const core::Motion<S>& motion = pilot_.motion();
    const core::Vec2<S> v =
        core::to_north_east(motion.psi, core::Vec2<S>{motion.nu.u, motion.nu.v});
    seen.velocity_n = {convert::q16(v.x), convert::q16(v.y)};
    if (!core::law_drives(state()) && way_due_.take_if_due(now_us)) {
      missions.check_way(*place, configuration().plan);
    }
  }
  fence_watch_.look(missions.fence(), configuration().stopping, seen);
}

/// By the sticks the fence is the driver's: he is warned, and the thrust goes on.
template <class S>
void Boat<S>::warn_of_fence(std::int64_t now_us) {
  if (state() != core::State::kManual) return;
  if ((conditions_ & core::kInsideFence) != 0 || !fence_warning_due_.take_if_due(now_us)) return;
  const bool ahead = !fence_watch_.stays() && !fence_watch_.is_outside();
  warn(ahead ? "fence ahead, or place unknown" : "outside the fence, or place unknown");
}

template <class S>
core::Thrust<S> Boat<S>::desired_thrust(std::int64_t now_us, S dt) {
  switch (state()) {
    case core::State::kManual: {
      const Sticks& sticks = supervisor_.sticks();
      law_output_.tau =
          core::stick_wrench(pilot_.law().propellers, convert::scalar<S>(sticks.surge),
                             convert::scalar<S>(sticks.yaw));
      law_output_.allocation = core::allocate(pilot_.law().propellers, law_output_.tau);
      break;
    }
    case core::State::kTest: {
      const MotorTest& test = *supervisor_.motor_test();
      law_output_.allocation.thrust = core::test_thrust(
          pilot_.law().propellers, test.stbd ? core::Propeller::kStbd : core::Propeller::kPort,
          convert::scalar<S>(test.share));
      break;
    }
    case core::State::kCoast:
      law_output_ = pilot_.coast(now_us, dt);
      break;
    case core::State::kFormation:
      law_output_ = pilot_.step(now_us, dt);
      break;
    case core::State::kAuto:
      sail_plan(now_us, dt);
      break;
    case core::State::kGuided: {
      const auto drive = vehicle_.drive(now_us);
      if (vehicle_.has_target() || (driven_ && !drive)) start_plan();
      driven_ = drive.has_value();
      law_output_ =
          drive ? pilot_.drive(convert::drive_of<S>(*drive), vehicle_.is_paused(), now_us, dt)
                : pilot_.sail(errand_.plan(), vehicle_.is_paused(), now_us, dt);
      break;
    }
    case core::State::kReturn:
      look_for_way();
      [[fallthrough]];
    case core::State::kLoiter:
      law_output_ = pilot_.sail(errand_.plan(), vehicle_.is_paused(), now_us, dt);
      break;
    case core::State::kDisarmed:
    case core::State::kHold:
    case core::State::kFault:
      return {};
  }
  return law_output_.allocation.thrust;
}

/// By the law, but for a voyage that measures the hull.
template <class S>
void Boat<S>::sail_plan(std::int64_t now_us, S dt) {
  const MissionService& missions = vehicle_.missions();
  if (vehicle_.missions().take_jump()) {
    voyage_.forget();
    start_plan();
  }
  constexpr bool kSailsVoyages = FLOTILLA_SAILS_VOYAGES != 0;
  if (kSailsVoyages && !voyage_.is_on()) begin_voyage();
  if (kSailsVoyages && voyage_.is_on()) {
    law_output_ = {};
    law_output_.allocation.thrust = sail_voyage(now_us, dt);
    if (voyage_.is_over()) start_plan();
  } else {
    const bool waits = waits_for_others(now_us);
    law_output_ = pilot_.sail(missions.plan(), vehicle_.is_paused() || waits, now_us, dt);
  }
  const PlanVessel<S>& sailed = pilot_.plan_vessel();
  auto reached = sailed.reached();
  if (kSailsVoyages && !reached && voyage_.is_over()) reached = voyage_.item();
  vehicle_.sailed(sailed.item(), reached, sailed.has_arrived(), counters_);
  if (!reached || reached_ == *reached) return;
  reached_ = static_cast<std::uint16_t>(*reached);
  set_home_of_plan(*reached);
}

/// For a boat that has fallen out of its slot, which is told once.
template <class S>
bool Boat<S>::waits_for_others(std::int64_t now_us) {
  const auto late = pilot_.reports().late(now_us);
  if (std::exchange(awaited_, late) == late) return late.has_value();
  Sentence told;
  if (late) {
    told << "waiting for boat " << static_cast<float>(*late) << ", out of its slot";
  } else {
    told << "not waiting any more";
  }
  warn(told.text());
  return late.has_value();
}

/// Where the plan has come to one, and the boat is in its room.
template <class S>
void Boat<S>::begin_voyage() {
  const MissionService& missions = vehicle_.missions();
  const std::size_t at = pilot_.plan_vessel().item();
  const PlanItem& ahead = missions.plan()[at];
  const std::uint32_t plan = missions.id(Stored::kPlan);
  if (!is_voyage(ahead) || (voyage_.is_of(plan, at) && voyage_.is_over())) return;
  VoyageRoom room = room_of(ahead, configuration().plan, configuration().stopping);
  room.plan = plan;
  room.item = at;
  const bool inside = convert::way_to<S>(pilot_.place(), {ahead.x, ahead.y}, room.radius_m).near;
  if (inside) voyage_.begin(room);
}

template <class S>
core::Thrust<S> Boat<S>::sail_voyage(std::int64_t now_us, S dt) {
  const VoyageRoom& room = voyage_.room();
  const PlanItem& centre = vehicle_.missions().plan()[room.item];
  const core::Motion<S> motion = pilot_.seen_motion(now_us);
  convert::Position here = pilot_.seen_from();
  here.north_m = here.north_m + motion.moved_n.x;
  here.east_m = here.east_m + motion.moved_n.y;
  const float far_m = 2 * room.radius_m;
  const auto [way, near] = convert::way_to<S>(here, {centre.x, centre.y}, far_m);
  const core::Vec2<S> v_n =
      core::to_north_east(motion.psi, core::Vec2<S>{motion.nu.u, motion.nu.v});
  if (way_due_.take_if_due(now_us)) {
    const S rest_s = convert::scalar<S>(room.rest_s);
    voyage_at_fence_ = leaves_fence(here, {rest_s * v_n.x, rest_s * v_n.y});
  }
  const bool waits = vehicle_.is_paused() || (conditions_ & core::kClear) == 0;
  const auto off_n =
      near ? core::Vec2<S>{-way.x, -way.y} : core::Vec2<S>{convert::scalar<S>(far_m), S(0)};
  const core::Thrust<S> share =
      voyage_.forward({off_n, v_n, motion.psi, motion.nu.r, waits, voyage_at_fence_}, dt);
  if (const auto news = voyage_.take_news()) tell_voyage(*news);
  const core::AllocationParams<S>& propellers = pilot_.law().propellers;
  const auto thrust = [&](S q) { return (q < S(0) ? propellers.R : propellers.F) * q; };
  return {thrust(share.port), thrust(share.stbd)};
}

/// Whether a boat that goes on that way leaves the stored fence, or the circle round home.
template <class S>
bool Boat<S>::leaves_fence(const convert::Position& here, const core::Vec2<S>& way) const {
  convert::Position there = here;
  there.north_m = there.north_m + way.x;
  there.east_m = there.east_m + way.y;
  const auto& limit_m = configuration().failsafes.fence_m;
  const auto home = limits_.home();
  if (limit_m && home &&
      !convert::way_to<S>(there, {home->latitude, home->longitude}, *limit_m).near) {
    return true;
  }
  const Fence& fence = vehicle_.missions().fence();
  if (!fence.is_on()) return false;
  const float margin_m = configuration().plan.margin_m;
  return !fence.refusal_of(here, convert::global_of(there), margin_m).empty();
}

template <class S>
void Boat<S>::tell_voyage(const VoyageNews& news) {
  using enum VoyageNews::Kind;
  const auto count = static_cast<float>(kVoyageSteps.size());
  Sentence text;
  text << "Voyage: ";
  if (news.kind == kOver) {
    text << "over, " << static_cast<float>(news.step) << " of " << count << " steps whole";
  } else if (news.kind == kLost) {
    text << "the boat does not come back to its room";
  } else {
    text << "step " << static_cast<float>(news.step);
    if (news.kind == kBegins) text << " of " << count << ", ";
    if (news.kind == kAgain) text << " again: ";
    if (news.kind == kLeftOut) text << " left out: ";
    text << news.what;
  }
  const std::uint8_t severity =
      news.kind == kLost ? link::mav::kSeverityError : link::mav::kSeverityInfo;
  vehicle_.send_statustext(severity, {text.text()}, counters_);
}

template <class S>
void Boat<S>::steer(std::int64_t now_us) {
  const S dt = last_tick_us_ ? convert::seconds<S>(now_us - *last_tick_us_) : S(0);
  pilot_.observe(now_us, dt, thrust_.given, core::armed(state()));
  learn(now_us, dt);
  const bool drive = supervisor_.may_drive(conditions_, now_us);
  if (!drive || !core::law_drives(state())) law_output_ = {};
  const core::Thrust<S> desired = drive ? desired_thrust(now_us, dt) : core::Thrust<S>{};
  // In COAST the law follows a dead-reckoned leader; telemetry reports the error to the one heard.
  const bool by_law = drive && keeps_slot();
  if (!by_law && seen()) {
    const auto slot = pilot_.look(now_us);
    law_output_.error = slot.error;
    law_output_.astern = slot.astern;
  }
  slot_astern_.look(law_output_.astern && seen() && configuration().formation.judges_station,
                    now_us);
  // Checked again after allocation, with newly evaluated conditions.
  const bool still = drive && core::may_drive(state(), conditions(now_us));
  thrust_ = thrusters_.step(still, desired, dt, state() != core::State::kCoast);
  collect_overflow();
  // After an overflow the thrust may be wrong. The next tick's conditions lead to FAULT.
  if (overflow_) thrust_ = thrusters_.step(false, desired, dt);
}

/// From the thrust given since the last tick, and the motion now.
template <class S>
void Boat<S>::learn(std::int64_t now_us, S dt) {
  if (!core::law_drives(state()) || (conditions_ & core::kOwnFresh) == 0) {
    learnt_.interrupt();
    return;
  }
  const auto of = [](S x) { return convert::in_float(x); };
  if (!learnt_.push({of(thrust_.given.X), of(thrust_.given.N)}, of(dt))) return;
  const core::Motion<S>& motion = pilot_.motion();
  const auto [sin, cos] = core::sin_cos(motion.psi);
  const core::Vec2<S>& current_n = pilot_.current_n();
  const bool applies = learnt_.take({of(motion.nu.u), of(motion.nu.v), of(motion.nu.r)},
                                    {of(sin), of(cos)}, {of(current_n.x), of(current_n.y)}, now_us);
  if (applies) configure();
}

template <class S>
void Boat<S>::warn(std::string_view text) {
  vehicle_.send_statustext(link::mav::kSeverityWarning, {text}, counters_);
}

template <class S>
void Boat<S>::send_warnings(std::int64_t now_us) {
  if (pilot_.take_frame_warning() && frame_warning_due_.take_if_due(now_us)) {
    warn("ODOMETRY refused: frame is not north-aligned");
  }
  if (!host_.parameters_saved && unsaved_warning_due_.take_if_due(now_us)) {
    warn("parameters are defaults: look at them and save");
  }
  if (host_.closed_links != 0 && closed_warning_due_.take_if_due(now_us)) {
    Sentence closed;
    closed << "MAVLink link " << static_cast<float>(std::countr_zero(host_.closed_links) + 1)
           << " is not open";
    warn(closed.text());
  }
  if (!std::exchange(save_failed_, host_.save_failed) && save_failed_) {
    vehicle_.send_statustext(link::mav::kSeverityError,
                             {"parameters could not be saved: see the host's disk"}, counters_);
  }
  const auto alarm = [&](std::optional<std::uint8_t> system, Schedule& due, std::string_view before,
                         std::string_view after) {
    if (!system || !due.take_if_due(now_us)) return;
    Sentence why;
    why << before << static_cast<float>(*system) << after;
    vehicle_.send_statustext(link::mav::kSeverityCritical, {why.text()}, counters_);
  };
  alarm(pilot_.doubled(now_us), double_due_, "two vessels use system id ", "");
  alarm(pilot_.late_neighbour(now_us), late_due_, "vessel ", " heard 3 s late: not kept clear of");
  if (pilot_.take_stranger() && quality_due_.take_if_due(now_us)) {
    warn("navigation unit first heard when armed: disarm");
  }
  warn_of_time(now_us);
  if ((conditions_ & core::kOwnGood) == 0 && quality_due_.take_if_due(now_us)) {
    Sentence poor;
    poor << "poor navigation: " << pilot_.own_quality().fault();
    warn(poor.text());
  }
  warn_of_fast_slot(now_us);
  warn_of_station();
  warn_of_current(now_us);
  warn_of_unsound_slot(now_us);
  warn_of_depth(now_us);
  warn_of_fence(now_us);
  tell_latency();
  tell_finding(now_us);
}

/// "Port 12 % weak since 10:31: THR_BALANCE 0.06", in UTC or in minutes since the start.
template <class S>
void Boat<S>::tell_finding(std::int64_t now_us) {
  using enum ModelMonitor::Number;
  const auto finding = learnt_.take_finding();
  if (!finding) return;
  const auto& [number, value, since_us] = *finding;
  Sentence text;
  if (number == kBalance) {
    const float change = value - parameters().THR_BALANCE;
    const float size = change < 0 ? -change : change;
    const float percent = to_nearest(200 * size / (1 + size), 1);
    text << (change < 0 ? "Starboard " : "Port ") << percent << " % weak";
  } else {
    text << (number == kDrag ? "Drag " : "Yaw damping ") << to_nearest(value, 10) << " x "
         << (number == kDrag ? "VES_D11" : "VES_D33");
  }
  text << " since ";
  put_time(text, since_us, host_.unix_us > 0 ? host_.unix_us - now_us : 0);
  if (number == kBalance) {
    text << ": THR_BALANCE " << to_nearest(value, 100);
  } else {
    text << ": identify the hull";
  }
  vehicle_.send_statustext(link::mav::kSeverityWarning, {text.text()}, counters_);
}

/// Reports a newly estimated latency of 0.03 s or more, and whether it is compensated.
template <class S>
void Boat<S>::tell_latency() {
  constexpr double kWorthAWord_s = 0.03;
  const auto latency_s = pilot_.latency_s();
  const bool told = std::exchange(latency_told_, latency_s.has_value());
  if (told || !latency_s || *latency_s < kWorthAWord_s) return;
  Sentence late;
  late << "navigation unit is " << hundredths(portable::nearest(100 * *latency_s))
       << " s late (no TIMESYNC)";
  const bool borne = (pilot_.conditions(now_us_) & core::kOwnPrompt) != 0;
  vehicle_.send_statustext(link::mav::kSeverityWarning, {late.text(), borne ? ": compensated" : ""},
                           counters_);
}

/// While disarmed, warns if TIMESYNC has not determined a state's age within 2 s.
template <class S>
void Boat<S>::warn_of_time(std::int64_t now_us) {
  const core::Conditions missing = ~conditions_ & (core::kOwnTimed | core::kLeaderTimed);
  untimed_.look(missing != 0, now_us);
  if (!untimed_.is() || missing == 0 || core::armed(state())) return;
  if (!time_warning_due_.take_if_due(now_us)) return;
  for_each_complaint(missing, [&](std::string_view why) { warn(why); });
}

/// Warns of a slot that has been too fast for 2 s; shorter excesses are noise of the leader's
/// state.
template <class S>
void Boat<S>::warn_of_fast_slot(std::int64_t now_us) {
  const auto [u, r] = convert::in_double(law_output_.too_fast);
  slot_too_fast_.look(u > 0 || r > 0, now_us);
  if (!slot_too_fast_.is() || !(u > 0 || r > 0) || !fast_slot_warning_due_.take_if_due(now_us))
    return;
  const Parameters p = derived(parameters());
  if (u > 0) warn(slot_needs(u, " m/s, LAW_U_MAX is ", p.LAW_U_MAX).text());
  if (r > 0) warn(slot_needs(r, " rad/s, LAW_R_MAX is ", p.LAW_R_MAX).text());
}

/// Gives the figures, one tick before COAST or HOLD, whose own message has none.
template <class S>
void Boat<S>::warn_of_station() {
  const core::Astray was = std::exchange(astray_, pilot_.astray());
  if (astray_ == was || astray_ == core::Astray::kNo || !keeps_slot()) return;
  const Parameters p = derived(parameters());
  Sentence why;
  if (astray_ == core::Astray::kSpins) {
    why << "boat spins: "
        << hundredths(portable::nearest(100 * convert::number(core::abs(pilot_.yaw_rate()))))
        << " rad/s, LAW_R_MAX is " << p.LAW_R_MAX;
  } else {
    const auto& e = law_output_.error.e;
    const auto off_m =
        hundredths(10 * portable::nearest(10 * convert::number(core::hypot(e.x, e.y))));
    if (astray_ == core::Astray::kLeft) {
      why << "boat left its slot: " << off_m << " m off, FS_SLOT_M is " << p.FS_SLOT_M;
    } else {
      why << "boat does not approach its slot: " << off_m << " m off";
    }
  }
  vehicle_.send_statustext(link::mav::kSeverityError, {why.text()}, counters_);
}

/// Tells that a boat that sails alone makes no way, or is carried off its place, though it gives all
/// its thrust: after 2 s, or at once where it holds because it does not respond.
template <class S>
void Boat<S>::warn_of_current(std::int64_t now_us) {
  const auto& e = law_output_.error.e;
  const bool was_alone = std::exchange(alone_, core::sails_alone(state()));
  const bool spent = alone_ && S(0) < law_output_.allocation.missing.X;
  const bool behind = S(1) < core::hypot(e.x, e.y) && pilot_.motion().nu.u < S(0.05);
  beaten_.look(spent && behind, now_us);
  const bool holds = was_alone && !alone_ && (conditions_ & core::kBoatAnswers) == 0;
  if (!holds && !(beaten_.is() && spent)) return;
  if (beaten_due_.take_if_due(now_us)) warn("boat makes no way: current, wind or propellers");
}

/// While armed, tells why the slot is not sound: at once, then every 10 s.
template <class S>
void Boat<S>::warn_of_unsound_slot(std::int64_t now_us) {
  if ((conditions_ & core::kSlotSound) != 0 || !core::armed(state())) return;
  if (!unsound_slot_warning_due_.take_if_due(now_us)) return;
  Sentence why;
  const SlotClaims& claims = pilot_.claims();
  if (claims.leaders(pilot_.tree_place())) {
    why << "slot is the leader's own place: set FORM_OFS_N, FORM_OFS_E";
  } else if (const auto rival = claims.rival(now_us, core::law_drives(state()))) {
    why << "slot is that of boat " << static_cast<float>(*rival) << " too";
  } else {
    why << "slot goes astern on the inside of the turn: bring it nearer, or astern of the leader";
  }
  vehicle_.send_statustext(link::mav::kSeverityError, {why.text()}, counters_);
}

/// Warns when the boat is armed, or when it learns then, that it is deeper in the tree than
/// certified.
template <class S>
void Boat<S>::warn_of_depth(std::int64_t now_us) {
  const std::size_t depth = pilot_.tree_place().depth(now_us);
  const auto most = configuration().formation.max_depth;
  const bool deep = core::armed(state()) && most && *most < depth;
  if (std::exchange(deep_, deep) || !deep) return;
  Sentence why;
  why << "boat is " << static_cast<float>(depth) << " deep in the tree, FORM_DEPTH is "
      << parameters().FORM_DEPTH;
  warn(why.text());
}

template <class S>
void Boat<S>::tell(std::int64_t now_us) {
  if ((conditions_ & core::kOwnFresh) != 0 && pilot_.located()) vehicle_.locate(pilot_.origin());
  if (vehicle_.tells_report()) vehicle_.report(report(now_us));
  vehicle_.tell(counters_);
  if (vehicle_.waits_for_future(pilot_.future_news())) {
    vehicle_.tell_future(pilot_.future_news(), pilot_.future(now_us), counters_);
  }
  if (kKeepsFleet) tell_fleet(now_us);
  const std::uint32_t news = pilot_.reference_news();
  if (!vehicle_.waits_for_reference(news)) return;
  if (const auto reference = this->reference(now_us)) {
    vehicle_.tell_reference(news, *reference, counters_);
  }
}

/// Followers of a boat in FORMATION, or in COAST for less than 1 s, follow the formation's
/// reference; after that they follow the boat itself, which comes to rest.
template <class S>
std::optional<link::FormationReference> Boat<S>::reference(std::int64_t now_us) const {
  const auto since_us = supervisor_.coasting_since_us();
  const bool coasts = since_us && now_us - *since_us < kShortCoast_us;
  return pilot_.reference(now_us, keeps_slot() || coasts);
}

template <class S>
std::optional<double> Boat<S>::separation_m() const {
  const auto& [yielding, known, predicted] = law_output_.separation;
  return known ? std::optional(convert::number(predicted)) : std::nullopt;
}

template <class S>
Report Boat<S>::report(std::int64_t now_us) {
  Report out;
  out.now_us = now_us;
  out.unix_us = host_.unix_us;
  out.conditions = conditions_;
  if ((conditions_ & core::kOwnFresh) != 0) {
    out.own = OwnReport{convert::boot_ms(now_us), pilot_.own_state(now_us), pilot_.located()};
    out.estimates = pilot_.estimates();
    out.gps = pilot_.gps(now_us);
  }
  out.balance = learnt_.told(ModelMonitor::Number::kBalance);
  out.drag = learnt_.told(ModelMonitor::Number::kDrag);
  out.yaw_damping = learnt_.told(ModelMonitor::Number::kYawDamping);
  out.home = limits_.home();
  if (error_known()) {
    const bool judged = keeps_slot() && configuration().formation.judges_station;
    const auto told_in_slot = judged ? std::optional(in_slot()) : std::nullopt;
    out.formation = FormationReport{told_in_slot, convert::in_double(law_output_.error.e),
                                    convert::in_double(law_output_.desired.nu_star),
                                    convert::in_double(law_output_.allocation.missing)};
  }
  out.reference = reference(now_us);
  out.depth = pilot_.depth();
  out.separation_m = separation_m();
  out.own_age_s = pilot_.own_age_s(now_us);
  out.leader_age_s = pilot_.leader_age_s(now_us);
  out.leader_uncertainty_m = pilot_.leader_uncertainty_m(now_us);
  const auto& [propulsion, failsafes] =
      std::tie(configuration().propulsion, configuration().failsafes);
  out.thrust = {convert::number(thrust_.thrust.port), convert::number(thrust_.thrust.stbd)};
  out.most_N = propulsion.ahead_N;
  out.least_N = -propulsion.astern_N;
  out.leader = core::sails_alone(state()) ? vehicle_.self().system : pilot_.leader();
  const auto esc = [&](std::uint8_t index) {
    return EscReport{index, can_.esc_status(index, now_us)};
  };
  out.escs = {esc(propulsion.port_esc), esc(propulsion.stbd_esc)};
  const Fence& fence = vehicle_.missions().fence();
  out.fenced = failsafes.fence_m.has_value() || fence.is_stored();
  out.fence_is_off = fence.is_stored() && !fence.is_on() && !failsafes.fence_m;
  if (fence.is_stored()) out.fence = fence_watch_.report();
  out.battery_limited = failsafes.battery_V.has_value();
  out.overruns = host_.overruns;
  return out;
}

template <class S>
Snapshot Boat<S>::snapshot() const {
  const auto& law = law_output_;
  const std::int64_t now_us = last_tick_us_.value_or(0);
  return {state(),
          conditions_,
          pilot_.own_age_s(now_us),
          pilot_.leader_age_s(now_us),
          pilot_.leader_uncertainty_m(now_us),
          pilot_.reference_age_s(now_us),
          pilot_.estimates(),
          error_known(),
          convert::in_double(law.error.e),
          convert::in_double(law.desired.nu_star),
          convert::in_double(law.tau),
          convert::in_double(thrust_.given),
          {convert::number(thrust_.thrust.port), convert::number(thrust_.thrust.stbd)},
          law.limits() | (thrust_.slew_limited ? core::kSlewLimit : 0),
          convert::in_double(law.too_fast),
          law.separation.yielding,
          in_slot(),
          separation_m(),
          counters_};
}

template class Boat<float>;
template class Boat<double>;
template class Boat<core::Q16>;

}  // namespace flotilla::app
