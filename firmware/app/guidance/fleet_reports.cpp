// SPDX-License-Identifier: MIT
#include "app/guidance/fleet_reports.hpp"

#include <algorithm>
#include <span>

#include "app/parameters.hpp"
#include "link/mavlink/mav.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;

// A boat silent for this long has left, or has failed: do not wait for it.
constexpr std::int64_t kMemberSilent_us = 3'000'000;
// After a longer absence a boat must come back to its slot before the leader waits for it: a leader
// at rest disturbs the boats that are in their slots.
constexpr std::int64_t kAbsent_us = 20'000'000;
constexpr std::uint8_t kReturns = 3;

}  // namespace

void FleetReports::configure(std::uint8_t own_system, std::uint8_t leader, std::int64_t wait_us) {
  if (own_system != own_) {
    members_ = {};
    used_ = 0;
  }
  if (leader != leader_) returns_ = 0;
  own_ = own_system;
  leader_ = leader;
  wait_us_ = wait_us;
}

std::int64_t FleetReports::Member::waited(std::int64_t now_us) const {
  const std::int64_t past_us = now_us - since_us;
  return out ? waited_us + past_us : std::max<std::int64_t>(0, waited_us - past_us);
}

void FleetReports::Member::note(bool is_out, std::int64_t now_us, std::int64_t most_us) {
  if (is_out == out) return;
  waited_us = static_cast<std::uint32_t>(std::min(waited(now_us), most_us));
  since_us = now_us;
  out = is_out;
}

FleetReports::Member* FleetReports::find(std::uint8_t system) {
  const auto used = std::span(members_).first(used_);
  const auto found = std::ranges::find(used, system, &Member::system);
  return found == used.end() ? nullptr : &*found;
}

/// A boat for which the table has no room is ignored. If this boat has taken the place of the root
/// that both followed, a member's time in its slot still counts.
void FleetReports::take_member(std::uint8_t system, const link::FormationReference& told,
                               std::int64_t now_us) {
  Member* member = find(system);
  const bool follows = (told.flags & mav::kReferenceFollowed) != 0;
  if (follows && system == leader_) root_ = told.root;
  const bool ours = follows && told.root == own_;
  if (!ours && member != nullptr) member->note(false, now_us, wait_us_);
  if (!follows) return;
  if (member == nullptr) {
    member = &*std::ranges::min_element(members_, {}, &Member::heard_us);
    if (member->system != 0 && now_us - member->heard_us <= kMemberSilent_us) return;
    *member = {};
    member->system = system;
    used_ = std::max(used_, static_cast<std::size_t>(member - members_.data()) + 1);
  }
  const bool stays = told.root == member->root || (ours && member->root == root_);
  if (!stays || now_us - member->heard_us > kAbsent_us) member->was_in = false;
  member->root = told.root;
  member->heard_us = now_us;
}

void FleetReports::hear(const link::Received& received, std::int64_t now_us) {
  const std::uint8_t from = received.from.system;
  if (from == own_ || from == 0) return;
  if (const auto* told = std::get_if<link::FormationReference>(&received.message)) {
    take_member(from, *told, now_us);
  } else if (const auto* value = std::get_if<link::NamedValueFloat>(&received.message)) {
    if (!link::is_text(value->name, "IN_SLOT")) return;
    Member* member = find(from);
    if (member == nullptr) return;
    member->was_in = member->was_in || value->value > 0;
    member->note(member->root == own_ && member->was_in && !(value->value > 0), now_us, wait_us_);
  } else if (const auto* beat = std::get_if<link::Heartbeat>(&received.message)) {
    if (from != leader_ || !link::is_vehicle(*beat)) return;
    constexpr std::uint8_t kSails = mav::kModeFlagCustom | mav::kModeFlagArmed;
    const bool returns = beat->custom_mode == mode::kReturn && (beat->base_mode & kSails) == kSails;
    if (!returns) returns_ = 0;
    if (returns && returns_ < kReturns) ++returns_;
    return_us_ = now_us;
  }
}

void FleetReports::forget_waits(std::int64_t now_us) {
  fleet_ = {};
  for (Member& member : std::span(members_).first(used_)) {
    member.waited_us = 0;
    member.since_us = now_us;
  }
}

std::optional<std::uint8_t> FleetReports::late(std::int64_t now_us) {
  const auto late = std::ranges::find_if(members_, [&](const Member& m) {
    return m.out && now_us - m.heard_us < kMemberSilent_us && m.waited(now_us) < wait_us_;
  });
  const bool any = late != members_.end();
  fleet_.note(any, now_us, wait_us_);
  if (!any || fleet_.waited(now_us) >= wait_us_) return std::nullopt;
  return late->system;
}

bool FleetReports::leader_returns(std::int64_t now_us) const {
  return returns_ == kReturns && now_us - return_us_ < kMemberSilent_us;
}

}  // namespace flotilla::app
