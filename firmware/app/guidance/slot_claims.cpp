// SPDX-License-Identifier: MIT
#include "app/guidance/slot_claims.hpp"

#include "app/convert/convert_reference.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;

// A boat silent for this long has given up its slot, or is out of range.
constexpr std::int64_t kRivalSilent_us = 3'000'000;
// Longer than a fleet's table takes to pass through a few boats.
constexpr std::int64_t kSettles_us = 2'000'000;
// Time for the other boat to stop, and for this one to hear of it.
constexpr std::int64_t kYields_us = 2'000'000;

}  // namespace

void SlotClaims::configure(std::uint8_t own_system, std::uint8_t leader,
                           const convert::WireOffset& slot, float beam_m) {
  if (leader != leader_ || own_system != own_) leader_is_vessel_ = false;
  own_ = own_system;
  leader_ = leader;
  beam_ = convert::wire_offset_of(beam_m, 0)[0];
  on_leader_ = is_one({slot, {}}, {});
  rival_ = 0;  // the slot may have changed; claims are repeated at 10 Hz
}

bool SlotClaims::is_one(const RootOffset& a, const RootOffset& b) const {
  const auto near = [this](const convert::WireOffset& p, const convert::WireOffset& q) {
    const std::int64_t x = std::int64_t{p[0]} - q[0], y = std::int64_t{p[1]} - q[1];
    return x * x + y * y < beam_ * beam_;
  };
  return near(a.n, b.n) && near(a.b, b.b);
}

void SlotClaims::hear(const link::Received& received, bool may_claim, const TreePlace& place,
                      std::int64_t now_us) {
  const std::uint8_t from = received.from.system;
  const auto* beat = std::get_if<link::Heartbeat>(&received.message);
  const auto* told = std::get_if<link::FormationReference>(&received.message);
  if (from == leader_) {
    leader_is_vessel_ =
        leader_is_vessel_ || told != nullptr || (beat != nullptr && link::is_vehicle(*beat));
  }
  if (told == nullptr || !may_claim || from == leader_ || from == own_) return;
  const auto mine = place.offset(now_us);
  const std::uint8_t root = place.branch(now_us).value_or(Branch{leader_, own_}).root;
  const bool follower = told->path[0] == own_;  // the leader checks its own slot
  if (mine && !follower && told->root == root && is_one(*mine, {told->offset_n, told->offset_b})) {
    if (rival_ == 0) rival_since_us_ = now_us;
    rival_ = from;
    rival_us_ = now_us;
    rival_sails_ = (told->flags & mav::kReferenceFollowed) != 0;
  } else if (from == rival_) {
    rival_ = 0;
  }
}

std::optional<std::uint8_t> SlotClaims::rival(std::int64_t now_us, bool sails) const {
  const std::int64_t patience_us = kSettles_us + (own_ < rival_ ? kYields_us : 0);
  const bool stays = rival_sails_ && now_us - rival_since_us_ >= patience_us;
  const bool counts = rival_ != 0 && (stays || !sails);
  const bool heard = counts && now_us - rival_us_ < kRivalSilent_us;
  return heard ? std::optional(rival_) : std::nullopt;
}

}  // namespace flotilla::app
