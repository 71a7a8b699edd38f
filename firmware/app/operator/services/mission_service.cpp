// SPDX-License-Identifier: MIT
#include "app/operator/services/mission_service.hpp"

#include <algorithm>
#include <utility>

#include "app/plan/errand.hpp"
#include "app/plan/zones.hpp"
#include "link/mavlink/crc32.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;

// MAVLink's guide repeats the request for an item after 250 ms, five times. With so few, a radio
// that loses every fourth message would fail to take a plan of 500 items.
constexpr std::int64_t kPatience_us = 250'000;
constexpr int kTries = 20;

link::MissionAck acknowledgement(const link::Address& to, std::uint8_t result, std::uint8_t type,
                                 std::uint32_t id = 0) {
  return {to, result, type, id};
}

PlanItem item_of(const link::MissionItemInt& m) {
  return {m.param, m.x, m.y, m.z, m.command, m.frame, m.autocontinue};
}

std::string_view bytes_of(Plan plan) {
  return {reinterpret_cast<const char*>(plan.data()), plan.size_bytes()};
}

/// Compares bits, so that a NaN equals itself.
bool is_same(const PlanItem& a, const PlanItem& b) {
  return bytes_of({&a, 1}) == bytes_of({&b, 1});
}

std::optional<Stored> kind_of(std::uint8_t mission_type) {
  if (mission_type >= kStoredKinds) return std::nullopt;
  return static_cast<Stored>(mission_type);
}

std::uint8_t type_of(Stored kind) { return static_cast<std::uint8_t>(kind); }

/// Defaults for a plan without its leading homes, which the targets of jumps still count.
PlanDefaults with_homes(PlanDefaults defaults, std::size_t homes) {
  defaults.homes = homes;
  return defaults;
}

PlanFault fault_of_last_of(Stored kind, Plan items, const PlanDefaults& defaults) {
  switch (kind) {
    case Stored::kFence:
      return fault_of_last_zone(items);
    case Stored::kRally:
      return fault_of_last_rally(items);
    case Stored::kPlan:
      break;
  }
  return fault_of_last(items, defaults);
}

PlanFault fault_of_whole(Stored kind, Plan items) {
  if (kind == Stored::kPlan) return fault_of(items);
  return kind == Stored::kFence ? fault_of_zones(items) : PlanFault{};
}

std::uint32_t id_of(Plan plan) {
  if (plan.empty()) return 0;
  return std::max(link::crc32(0xFFFFFFFFU, bytes_of(plan)), kLostId + 1);
}

}  // namespace

std::optional<link::Message> MissionService::answer(const RequestMessage& asked, const Asker& asker,
                                                    const PlanDefaults& defaults,
                                                    std::int64_t now_us) {
  const link::Address& to = asker.from;
  if (const auto* list = std::get_if<link::MissionRequestList>(&asked)) {
    const auto kind = kind_of(list->mission_type);
    const Store none{}, &kept = kind ? store(*kind) : none;
    return link::MissionCount{to, static_cast<std::uint16_t>(kept.count), list->mission_type,
                              kept.id};
  }
  if (const auto* request = std::get_if<link::MissionRequestInt>(&asked)) {
    return item(request->seq, to, request->mission_type);
  }
  if (const auto* old = std::get_if<link::MissionRequest>(&asked)) {
    return item(old->seq, to, old->mission_type);
  }
  if (const auto* count = std::get_if<link::MissionCount>(&asked)) {
    return begin(*count, asker, now_us);
  }
  if (const auto* given = std::get_if<link::MissionItemInt>(&asked)) {
    return take(*given, asker, defaults, now_us);
  }
  if (const auto* old = std::get_if<link::MissionItem>(&asked)) {
    // MISSION_ITEM's floats give a place only to a metre; the boat asks by MISSION_REQUEST_INT.
    return acknowledgement(to, mav::kMissionUnsupported, old->mission_type);
  }
  if (const auto* asked_clear = std::get_if<link::MissionClearAll>(&asked)) {
    return clear(*asked_clear, asker);
  }
  if (const auto* end = std::get_if<link::MissionAck>(&asked)) {
    const bool over = end->type != mav::kMissionAccepted && is_from_uploader(asker);
    if (over && end->mission_type == type_of(upload_->kind)) upload_.reset();
  }
  return std::nullopt;
}

/// Number of leading homes. ArduPilot's clients send home as the first item, with an altitude above
/// sea level. It is stored, but never sailed to.
std::size_t MissionService::homes_of(Plan items) const {
  const bool home = homes_ && !items.empty() && items[0].command == mav::kNavWaypoint &&
                    items[0].frame == mav::kFrameGlobal;
  return home ? 1 : 0;
}

Plan MissionService::sailed_of(Stored kind, Plan items) const {
  return kind == Stored::kPlan ? items.subspan(homes_of(items)) : items;
}

/// Clears all kinds that are asked for, or none if one of them may not change now or another
/// station uploads.
link::Message MissionService::clear(const link::MissionClearAll& asked, const Asker& asker) {
  const auto is_asked = [&](Stored kind) {
    return asked.mission_type == type_of(kind) || asked.mission_type == mav::kMissionTypeAll;
  };
  constexpr std::array kKinds{Stored::kPlan, Stored::kFence, Stored::kRally};
  for (const Stored kind : kKinds) {
    const bool others = upload_ && !is_from_uploader(asker);
    if (!is_asked(kind) || (asker.may_change(kind) && !others)) continue;
    const std::string_view why = others ? "another upload is running" : "";
    refuse(asker, kind, {mav::kMissionDenied, why});
    return acknowledgement(asker.from, mav::kMissionDenied, asked.mission_type);
  }
  for (const Stored kind : kKinds) {
    if (!is_asked(kind)) continue;
    if (upload_ && upload_->kind == kind) upload_.reset();
    replace(kind, {});
  }
  return acknowledgement(asker.from, mav::kMissionAccepted, asked.mission_type);
}

bool MissionService::is_from_uploader(const Asker& asker) const {
  return upload_ && upload_->asker.from == asker.from && upload_->asker.link == asker.link;
}

std::optional<link::Message> MissionService::begin(const link::MissionCount& count,
                                                   const Asker& asker, std::int64_t now_us) {
  const auto kind = kind_of(count.mission_type);
  if (!kind) return acknowledgement(asker.from, mav::kMissionUnsupported, count.mission_type);
  if (!asker.may_change(*kind)) return refuse(asker, *kind, {mav::kMissionDenied});
  if (upload_ && !is_from_uploader(asker)) {
    // The same sender, on another link: a copy that another vessel has forwarded.
    if (upload_->asker.from == asker.from) return std::nullopt;
    return refuse(asker, *kind, {mav::kMissionDenied, "another upload is running"});
  }
  if (count.count > std::min(store(*kind).room.size(), incoming_.size())) {
    return refuse(asker, *kind, {mav::kMissionNoSpace});
  }
  upload_ = Upload{asker, *kind, count.count, 0, now_us, 0};
  if (count.count == 0) return finish(asker);
  return ask(now_us);
}

std::optional<link::Message> MissionService::take(const link::MissionItemInt& given,
                                                  const Asker& asker, const PlanDefaults& defaults,
                                                  std::int64_t now_us) {
  constexpr std::uint8_t kCurrent = 1;  // larger: ArduPilot's "go here", "change altitude"
  const auto kind = kind_of(given.mission_type);
  if (!kind || given.current > kCurrent) {
    return acknowledgement(asker.from, mav::kMissionUnsupported, given.mission_type);
  }
  // A late copy, or an item that was not asked for, changes nothing. A sender that missed the
  // acknowledgement of its last item gets it again.
  const Store& kept = store(*kind);
  const bool uploaded = asker.from == kept.from && asker.link == kept.link;
  if (!upload_ && uploaded && given.seq + std::size_t{1} == kept.count &&
      is_same(item_of(given), kept.room[given.seq])) {
    return acknowledgement(asker.from, mav::kMissionAccepted, given.mission_type, kept.id);
  }
  if (!is_from_uploader(asker) || upload_->kind != *kind) return std::nullopt;
  if (given.seq < upload_->next) return std::nullopt;
  if (given.seq > upload_->next) return ask(now_us);
  if (!asker.may_change(*kind)) {
    return refuse(asker, *kind, {mav::kMissionDenied, {}, given.seq});
  }
  incoming_[upload_->next] = item_of(given);
  if (PlanFault fault = fault_of_last_incoming(defaults)) {
    fault.item = given.seq;
    return refuse(asker, *kind, fault);
  }
  upload_->tries = 0;
  if (++upload_->next < upload_->count) return ask(now_us);
  const Plan sailed = sailed_of(*kind, incoming_.first(upload_->count));
  if (sailed.empty()) upload_->count = 0;  // a home alone is no plan
  const PlanFault whole = sailed.empty() ? PlanFault{} : fault_of_whole(*kind, sailed);
  if (whole) return refuse(asker, *kind, whole);
  return finish(asker);
}

PlanFault MissionService::fault_of_last_incoming(const PlanDefaults& defaults) const {
  const Plan all = incoming_.first(upload_->next + 1);
  const Plan items = sailed_of(upload_->kind, all);
  if (items.empty()) return {};
  const PlanDefaults mine = with_homes(defaults, all.size() - items.size());
  if (const PlanFault fault = fault_of_last_of(upload_->kind, items, mine)) return fault;
  if (upload_->kind == Stored::kPlan) return fence_fault_of_last(fence_, items, mine);
  if (upload_->kind == Stored::kFence) return {};
  const auto why = fence_.refusal_of({items.back().x, items.back().y}, defaults.margin_m);
  return why.empty() ? PlanFault{} : PlanFault{mav::kMissionInvalid, why};
}

/// Judges the stored items again, but not by LAW_U_MAX and WP_RADIUS: a plan that these parameters
/// now contradict is kept, and sailed as they permit.
PlanFault MissionService::restore(Stored kind, Plan items, const PlanDefaults& defaults) {
  if (items.empty()) return {};
  if (items.size() > store(kind).room.size()) return {mav::kMissionNoSpace, "too many items"};
  const Plan sailed = sailed_of(kind, items);
  PlanDefaults mine = with_homes(defaults, items.size() - sailed.size());
  mine.fastest_mps = 0;
  mine.radius_m = std::max(mine.radius_m, 1.0F);
  for (std::size_t count = 1; count <= sailed.size(); ++count) {
    if (const PlanFault fault = fault_of_last_of(kind, sailed.first(count), mine)) return fault;
  }
  if (const PlanFault fault = fault_of_whole(kind, sailed)) return fault;
  replace(kind, items);
  return {};
}

link::Message MissionService::finish(const Asker& asker) {
  const Stored kind = upload_->kind;
  const bool judged = upload_->judged;
  replace(kind, incoming_.first(upload_->count));
  store(kind).from = asker.from;
  store(kind).link = asker.link;
  upload_.reset();
  news_ = News{.kind = News::Kind::kStored, .what = kind};
  // Each leg was judged on arrival. Only if something in Checked has changed is a new check needed.
  if (kind == Stored::kPlan) check_.begin(judged && checked_.map == fence_.drawn());
  return acknowledgement(asker.from, mav::kMissionAccepted, type_of(kind), store(kind).id);
}

void MissionService::replace(Stored kind, Plan items) {
  Store& kept = store(kind);
  std::ranges::copy(items, kept.room.begin());
  kept.count = items.size();
  kept.id = id_of(kept.items());
  if (kind == Stored::kFence) fence_.set(kept.items());
  if (kind != Stored::kPlan) return;
  check_.begin();
  way_why_ = {};
  current_ = homes_of(plan());
  progress_ = {};
  ++round_;
  complete_ = false;
  item_set_ = false;
}

link::Message MissionService::refuse(const Asker& asker, Stored kind, const PlanFault& fault) {
  if (is_from_uploader(asker)) upload_.reset();
  std::string_view why = fault.why;
  if (fault.result == mav::kMissionNoSpace) why = "too many items";
  if (fault.result == mav::kMissionDenied && why.empty()) why = "needs HOLD and MAV_GCS_SYSID";
  news_ = News{News::Kind::kRefused, kind, fault.item, why};
  return acknowledgement(asker.from, fault.result, type_of(kind));
}

link::Message MissionService::ask(std::int64_t now_us) {
  upload_->asked_us = now_us;
  const auto seq = static_cast<std::uint16_t>(upload_->next);
  return link::MissionRequestInt{upload_->asker.from, seq, type_of(upload_->kind)};
}

std::optional<MissionService::Repeated> MissionService::repeat(std::int64_t now_us) {
  if (!upload_ || now_us - upload_->asked_us < kPatience_us) return std::nullopt;
  const std::uint8_t link = upload_->asker.link;
  if (upload_->tries++ < kTries) return Repeated{link, ask(now_us)};
  const link::Address to = upload_->asker.from;
  const std::uint8_t type = type_of(upload_->kind);
  news_ = News{News::Kind::kRefused, upload_->kind, upload_->next, "upload timed out"};
  upload_.reset();
  return Repeated{link, acknowledgement(to, mav::kMissionCancelled, type)};
}

link::Message MissionService::item(std::size_t seq, const link::Address& to,
                                   std::uint8_t type) const {
  const auto kind = kind_of(type);
  if (!kind || seq >= store(*kind).count) {
    return acknowledgement(to, mav::kMissionInvalidSequence, type);
  }
  const PlanItem& p = store(*kind).room[seq];
  return link::MissionItemInt{to,      static_cast<std::uint16_t>(seq),
                              p.frame, p.command,
                              0,       p.autocontinue,
                              p.param, p.x,
                              p.y,     p.z,
                              type};
}

std::optional<MissionService::News> MissionService::take_news() {
  return std::exchange(news_, std::nullopt);
}

bool MissionService::set_current(std::size_t item, bool anew) {
  if (item >= store(Stored::kPlan).count) return false;
  const std::size_t first = homes_of(plan());
  current_ = std::max(item, first);
  progress_.go_to(plan(), current_, anew || current_ == first);
  ++round_;
  complete_ = false;
  item_set_ = true;
  way_why_ = {};
  return true;
}

void MissionService::begin_round() {
  if (std::exchange(complete_, false)) ++round_;
}

bool MissionService::take_item_set() { return std::exchange(item_set_, false); }

void MissionService::sailed(const PlanMark& ahead, bool complete) {
  const auto is_there = [&] {
    return complete || (current_ == ahead.item && progress_.jumps() == ahead.jumps);
  };
  // Places that are too near to tell apart may be passed in any number.
  std::size_t left = 4 * plan().size();
  while (left-- > 0 && current_ < plan().size() && !is_there()) {
    current_ = progress_.pass(plan(), current_);
  }
  current_ = complete ? homes_of(plan()) : ahead.item;
  if (complete) progress_ = {};
  complete_ = complete;
}

bool MissionService::enable_fence(bool on) {
  if (!fence_.is_stored()) return false;
  fence_.enable(on);
  checked_.map = fence_.drawn();
  judge_anew();
  return true;
}

/// Call when something in Checked has changed: judges the plan again, and a plan in upload once
/// it is whole.
void MissionService::judge_anew() {
  check_.begin();
  way_why_ = {};
  if (upload_) upload_->judged = false;
}

void MissionService::check_plan(const PlanDefaults& defaults) {
  const Checked now{fence_.drawn(), defaults.margin_m, defaults.radius_m};
  if (std::exchange(checked_, now) != now) judge_anew();
  const std::size_t homes = homes_of(plan());
  if (!check_.forward(fence_, plan().subspan(homes), with_homes(defaults, homes))) return;
  news_ = News{News::Kind::kPlanLeavesFence, Stored::kPlan, homes + check_.item(), check_.why()};
}

std::string_view MissionService::refusal_of_way(const convert::Position& here, std::size_t item,
                                                const PlanDefaults& defaults, bool anew) const {
  PlanReader reader;
  reader.begin({std::max(item, homes_of(plan())),
                convert::global_of(here),
                {},
                anew ? PlanProgress{} : progress_},
               defaults);
  auto first = reader.next(plan());
  if (first && !place_of(plan()[first->mark.item])) first = reader.next(plan());  // a wait here
  if (!first) return {};
  if (!convert::way_to<double>(here, first->place, start_m(item)).near) return "too far away";
  return fence_.is_on() ? fence_.refusal_of(here, first->place, defaults.margin_m)
                        : std::string_view{};
}

void MissionService::check_way(const convert::Position& here, const PlanDefaults& defaults) {
  way_why_ = refusal_of_way(here, current_, defaults);
}

bool MissionService::plan_is_sound(bool in_auto) const {
  if (in_auto) return check_.why().empty();
  return !plan().empty() && check_.is_over() && plan_trouble().empty();
}

convert::GlobalPoint MissionService::return_place(const convert::Position& here,
                                                  const convert::GlobalPoint& home,
                                                  const PlanDefaults& defaults,
                                                  const std::optional<float>& fence_m) const {
  const convert::Position at_home{0, 0, {home.latitude, home.longitude, 0, 0}};
  const auto leads_to = [&](const convert::GlobalPoint& place) {
    return fence_.is_straight(here, place, defaults.margin_m);
  };
  convert::GlobalPoint best = home;
  double nearest_m = 0;
  bool found = false, straight = false;
  for (const PlanItem& point : stored(Stored::kRally)) {
    const convert::GlobalPoint place{point.x, point.y};
    if (!fence_.refusal_of(place, 0).empty()) continue;
    const convert::Position there{0, 0, {place.latitude, place.longitude, 0, 0}};
    if (fence_m && convert::distance_m(at_home, there) > double{*fence_m}) continue;
    const double away_m = convert::distance_m(here, there);
    if (away_m > double{kErrandReach_m}) continue;
    const bool leads = leads_to(place);
    if (found && (straight != leads ? straight : nearest_m <= away_m)) continue;
    best = place;
    nearest_m = away_m;
    straight = leads;
    found = true;
  }
  if (!found || straight || convert::distance_m(here, at_home) > double{kErrandReach_m})
    return best;
  return leads_to(home) ? home : best;
}

}  // namespace flotilla::app
