// SPDX-License-Identifier: MIT
#include "app/operator/mission_service.hpp"

#include <algorithm>
#include <utility>

#include "link/mavlink/crc32.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;

// MAVLink's guide has an item asked for again after 250 ms, five times; with that, a radio that
// loses every fourth message would lose a plan of 500 items.
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

/// Bit by bit: a NaN is the same as itself.
bool is_same(const PlanItem& a, const PlanItem& b) {
  return bytes_of({&a, 1}) == bytes_of({&b, 1});
}

std::uint32_t id_of(Plan plan) {
  if (plan.empty()) return 0;
  return std::max(link::crc32(0xFFFFFFFFU, bytes_of(plan)), std::uint32_t{1});
}

}  // namespace

std::optional<link::Message> MissionService::answer(const RequestMessage& asked, const Asker& asker,
                                                    const PlanDefaults& defaults,
                                                    std::int64_t now_us) {
  const link::Address& to = asker.from;
  if (const auto* list = std::get_if<link::MissionRequestList>(&asked)) {
    const bool ours = list->mission_type == mav::kMissionTypePlan;
    const auto count = static_cast<std::uint16_t>(ours ? count_ : 0);
    return link::MissionCount{to, count, list->mission_type, ours ? id_ : 0};
  }
  if (const auto* wish = std::get_if<link::MissionRequestInt>(&asked)) {
    return item(wish->seq, to, wish->mission_type);
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
    // Its floats know a place to a metre only: the sender is asked for MISSION_ITEM_INT.
    return acknowledgement(to, mav::kMissionUnsupported, old->mission_type);
  }
  if (const auto* clear = std::get_if<link::MissionClearAll>(&asked)) {
    const bool ours =
        clear->mission_type == mav::kMissionTypePlan || clear->mission_type == mav::kMissionTypeAll;
    if (ours && !asker.may_change) return refuse(asker, {mav::kMissionDenied}, 0);
    if (ours) {
      upload_.reset();
      replace(0);
    }
    return acknowledgement(to, mav::kMissionAccepted, clear->mission_type);
  }
  if (const auto* end = std::get_if<link::MissionAck>(&asked)) {
    const bool over = end->type != mav::kMissionAccepted && is_from_uploader(asker);
    if (over && end->mission_type == mav::kMissionTypePlan) upload_.reset();
  }
  return std::nullopt;
}

bool MissionService::is_from_uploader(const Asker& asker) const {
  return upload_ && upload_->asker.from == asker.from && upload_->asker.link == asker.link;
}

std::optional<link::Message> MissionService::begin(const link::MissionCount& count,
                                                   const Asker& asker, std::int64_t now_us) {
  if (count.mission_type != mav::kMissionTypePlan) {
    return acknowledgement(asker.from, mav::kMissionUnsupported, count.mission_type);
  }
  if (!asker.may_change) return refuse(asker, {mav::kMissionDenied}, 0);
  if (upload_ && !is_from_uploader(asker)) {
    // Of the same sender by another link: a copy that another vessel has handed on.
    if (upload_->asker.from == asker.from) return std::nullopt;
    return refuse(asker, {mav::kMissionDenied, "another plan is being sent"}, 0);
  }
  if (count.count > incoming_.size()) return refuse(asker, {mav::kMissionNoSpace}, 0);
  upload_ = Upload{asker, count.count, 0, now_us, 0};
  if (count.count == 0) return finish(asker);
  return ask(now_us);
}

std::optional<link::Message> MissionService::take(const link::MissionItemInt& given,
                                                  const Asker& asker, const PlanDefaults& defaults,
                                                  std::int64_t now_us) {
  constexpr std::uint8_t kCurrent = 1;  // larger: ArduPilot's "go there now"
  if (given.mission_type != mav::kMissionTypePlan || given.current > kCurrent) {
    return acknowledgement(asker.from, mav::kMissionUnsupported, given.mission_type);
  }
  // A late copy, or an item that nobody has asked for, changes nothing. Who did not hear that his
  // last item was the last one is told again.
  if (!upload_ && asker.from == stored_from_ && given.seq + std::size_t{1} == count_ &&
      is_same(item_of(given), plan_[given.seq])) {
    return acknowledgement(asker.from, mav::kMissionAccepted, mav::kMissionTypePlan, id_);
  }
  if (!is_from_uploader(asker)) return std::nullopt;
  if (given.seq < upload_->next) return std::nullopt;
  if (given.seq > upload_->next) return ask(now_us);
  if (!asker.may_change) return refuse(asker, {mav::kMissionDenied}, given.seq);
  incoming_[upload_->next] = item_of(given);
  const PlanFault fault = fault_of_last(incoming_.first(upload_->next + 1), defaults);
  if (fault) return refuse(asker, fault, given.seq);
  upload_->tries = 0;
  if (++upload_->next < upload_->count) return ask(now_us);
  if (const PlanFault whole = fault_of(Plan(incoming_.first(upload_->count)))) {
    return refuse(asker, whole, 0);
  }
  return finish(asker);
}

PlanFault MissionService::restore(Plan plan, const PlanDefaults& defaults) {
  if (plan.empty()) return {};
  if (plan.size() > plan_.size()) return {mav::kMissionNoSpace, "too many items"};
  for (std::size_t count = 1; count <= plan.size(); ++count) {
    if (const PlanFault fault = fault_of_last(plan.first(count), defaults)) return fault;
  }
  if (const PlanFault fault = fault_of(plan)) return fault;
  std::ranges::copy(plan, plan_.begin());
  replace(plan.size());
  return {};
}

link::Message MissionService::finish(const Asker& asker) {
  const std::size_t count = upload_->count;
  std::swap(plan_, incoming_);
  replace(count);
  stored_from_ = asker.from;
  upload_.reset();
  news_ = News{.stored = true};
  return acknowledgement(asker.from, mav::kMissionAccepted, mav::kMissionTypePlan, id_);
}

void MissionService::replace(std::size_t count) {
  count_ = count;
  id_ = id_of(plan());
  current_ = 0;
  complete_ = false;
  jumped_ = false;
}

link::Message MissionService::refuse(const Asker& asker, const PlanFault& fault, std::size_t item) {
  if (is_from_uploader(asker)) upload_.reset();
  std::string_view why = fault.why;
  if (fault.result == mav::kMissionNoSpace) why = "too many items";
  if (fault.result == mav::kMissionDenied && why.empty()) why = "HOLD first, or not your boat";
  news_ = News{.item = item, .why = why};
  return acknowledgement(asker.from, fault.result, mav::kMissionTypePlan);
}

link::Message MissionService::ask(std::int64_t now_us) {
  upload_->asked_us = now_us;
  const auto seq = static_cast<std::uint16_t>(upload_->next);
  return link::MissionRequestInt{upload_->asker.from, seq, mav::kMissionTypePlan};
}

std::optional<MissionService::Repeated> MissionService::repeat(std::int64_t now_us) {
  if (!upload_ || now_us - upload_->asked_us < kPatience_us) return std::nullopt;
  const std::uint8_t link = upload_->asker.link;
  if (upload_->tries++ < kTries) return Repeated{link, ask(now_us)};
  const link::Address to = upload_->asker.from;
  news_ = News{.item = upload_->next, .why = "its sender is silent"};
  upload_.reset();
  return Repeated{link, acknowledgement(to, mav::kMissionCancelled, mav::kMissionTypePlan)};
}

link::Message MissionService::item(std::size_t seq, const link::Address& to,
                                   std::uint8_t type) const {
  if (type != mav::kMissionTypePlan || seq >= count_) {
    return acknowledgement(to, mav::kMissionInvalidSequence, type);
  }
  const PlanItem& p = plan_[seq];
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

bool MissionService::set_current(std::size_t item) {
  if (item >= count_) return false;
  current_ = item;
  complete_ = false;
  jumped_ = true;
  return true;
}

bool MissionService::take_jump() { return std::exchange(jumped_, false); }

void MissionService::sailed(std::size_t item, bool complete) {
  current_ = complete ? 0 : item;
  complete_ = complete;
}

}  // namespace flotilla::app
