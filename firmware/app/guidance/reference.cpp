// SPDX-License-Identifier: MIT
#include "app/guidance/reference.hpp"

#include <utility>

namespace flotilla::app {
namespace {

// Greatest ages of a reference that is followed, and of one that is sent, which must last one more
// hop. An S-curve cannot be extrapolated for longer.
constexpr std::int64_t kOldestFollowed_us = 4'000'000, kOldestTold_us = 3'000'000;
// A lower sequence number with a motion later by more than this means that the maker restarted.
constexpr std::int64_t kRestart_us = 1'000'000;
// Interval of references made from a plan, whose motion is exact: no follower needs more.
constexpr std::int64_t kTold_us = 100'000;
// A received reference that is newer by less than this is ignored.
constexpr std::int64_t kNews_us = 45'000;
// Validity of a future; greatest age of a reference that has one, to be followed or sent.
constexpr std::int64_t kFuture_us = 12'000'000, kOldestCovered_us = 9'000'000;

/// The age field of a message sent now.
std::uint16_t age_ms(std::int64_t now_us, std::int64_t valid_us) {
  const std::int64_t age_us = convert::us_of_ms(now_us) - valid_us;
  return static_cast<std::uint16_t>(age_us < 0 ? 0 : (age_us + 500) / 1000);
}

}  // namespace

template <class S>
void Reference<S>::configure(const Configuration::Formation& formation,
                             const core::ForesightLimits<S>& limits, std::uint8_t own_system) {
  on_ = formation.follows_root;
  limits_ = limits;
  reach_ = formation.reach_m.value_or(convert::kNear_m);
  clocks_.set_lag(formation.leader_lag_us);
  own_ = {own_system, formation.leader,
          convert::wire_offset_of(formation.north_m, formation.east_m), formation.turns};
  settle();
}

template <class S>
void Reference<S>::lead(bool on) {
  leads_ = on;
  settle();
}

template <class S>
void Reference<S>::settle() {
  const TreePlace::Own own = leads_ ? TreePlace::Own{own_.system} : own_;
  if (own.leader != place_.own().leader || own.system != place_.own().system) {
    held_.reset();
    guard_ = {};
    shapes_ = false;
    future_.reset();
  }
  place_.configure(own);
}

template <class S>
void Reference<S>::take(link::Address from, const link::FormationReference& m,
                        const convert::Position* own, std::int64_t now_us,
                        link::Counters& counters) {
  if (!on_ || from.system == place_.own().system) return;
  const bool leads = from.system == place_.own().leader;
  const std::size_t rank = leads ? 0 : 1 + length_of(m.path);
  const auto stamp = clocks_.heard(from, static_cast<std::uint8_t>(rank), m.time_boot_ms, now_us);
  if (!stamp) return;
  const std::int64_t age_us = std::int64_t{m.age_ms} * 1000;
  const std::int64_t valid_us = stamp->us - age_us, least_us = stamp->least_us - age_us;
  // A reference with a known future does not grow too old for the boats behind.
  const bool covered = lasting_us(now_us, 0) > now_us - valid_us;
  if (leads && !stamp->overtaken) place_.hear(m, covered ? now_us : valid_us, now_us);
  const auto branch = place_.branch(now_us);
  if (own == nullptr || branch != Branch{m.root, m.maker}) return;
  if (!is_newer(m, *branch, valid_us)) return;
  if (held_ && held_->branch.root != branch->root) guard_.forget();
  const auto root = convert::root_state_of<S>(m, own->origin.altitude);
  if (!root) {
    ++counters.mavlink_bad_value;
  } else if (now_us - least_us > lasting_us(now_us, kOldestFollowed_us) ||
             !believe(*root, valid_us, now_us)) {
    ++counters.reference_refused;
  } else {
    const bool timed = stamp->timed && (m.flags & link::mav::kReferenceUntimed) == 0;
    hold(*branch, m.sequence, m, *root, valid_us, is_near(*own, *root, now_us), timed);
  }
}

template <class S>
void Reference<S>::take(link::Address from, const link::FormationFuture& m, std::int64_t now_us,
                        link::Counters& counters) {
  if (!on_ || from.system == place_.own().system) return;
  const Branch branch{m.root, m.maker};
  if (place_.branch(now_us) != branch) return;
  const auto rank = static_cast<std::uint8_t>(from.system == place_.own().leader ? 0 : 255);
  const auto stamp = clocks_.heard(from, rank, m.time_boot_ms, now_us);
  if (!stamp) return;
  const std::int64_t begun_us = stamp->us - std::int64_t{m.age_ms} * 1000;
  if (future_ && future_->branch == branch) {
    const auto ahead = static_cast<std::int16_t>(m.sequence - future_->told.sequence);
    if (ahead <= 0 && begun_us - future_->begun_us < kRestart_us) return;
  }
  const auto future = convert::future_of<S>(m);
  if (!future) {
    ++counters.mavlink_bad_value;
  } else if (now_us - begun_us < kFuture_us) {
    future_.emplace(branch, m, *future, begun_us, stamp->timed);
    ++future_news_;
    walks_ = false;
  }
}

/// The future of the held reference's branch, while it is valid.
template <class S>
const typename Reference<S>::HeldFuture* Reference<S>::future(std::int64_t now_us) const {
  if (!future_ || !held_ || future_->branch != held_->branch || !future_->timed ||
      now_us - future_->begun_us > kFuture_us) {
    return nullptr;
  }
  return &*future_;
}

/// The greatest age of a reference; plain_us if its future is unknown.
template <class S>
std::int64_t Reference<S>::lasting_us(std::int64_t now_us, std::int64_t plain_us) const {
  return future(now_us) != nullptr ? kOldestCovered_us : plain_us;
}

/// Advances the walk along the reference's future to the present; drops a future that the reference
/// contradicts.
template <class S>
void Reference<S>::walk(std::int64_t now_us) {
  const HeldFuture* told = future(now_us);
  if (told == nullptr) {
    walks_ = false;
    return;
  }
  if (!walks_) {
    const auto since = convert::seconds<S>(held_->valid_us - told->begun_us);
    if (!core::future_holds(told->future, held_->root.motion.nu, since)) {
      future_.reset();
      return;
    }
    walk_ = core::future_start(held_->root.motion, since);
    walks_ = true;
  }
  core::future_forward(told->future, walk_, convert::seconds<S>(now_us - told->begun_us));
}

/// Whether the root, and our slot relative to it, are within reach.
template <class S>
bool Reference<S>::is_near(const convert::Position& own, const convert::RootState<S>& root,
                           std::int64_t now_us) const {
  const auto& offset = place_.offset(now_us);
  if (!offset) return false;
  const core::Vec2<S> n = convert::offset_of<S>(offset->n);
  const core::Vec2<S> b = core::to_north_east(root.motion.psi, convert::offset_of<S>(offset->b));
  convert::Position slot = root.position;
  slot.north_m = slot.north_m + (n.x + b.x);
  slot.east_m = slot.east_m + (n.y + b.y);
  return convert::near(own, root.position) && convert::near(own, slot, reach_);
}

/// Whether a reference is new to us: not one that another boat has already relayed to us, nor one
/// newer by less than kNews_us. One from a restarted maker is new.
template <class S>
bool Reference<S>::is_newer(const link::FormationReference& m, const Branch& branch,
                            std::int64_t valid_us) const {
  if (!held_ || held_->branch != branch) return true;
  const auto ahead = static_cast<std::int16_t>(m.sequence - held_->sequence);
  const std::int64_t later_us = valid_us - held_->valid_us;
  if (ahead > 0) return later_us < 0 || later_us >= kNews_us;
  return ahead < 0 && later_us > kRestart_us;
}

/// Accepts a state that is plausible after the previous one; false if it is not.
template <class S>
bool Reference<S>::believe(const convert::RootState<S>& root, std::int64_t valid_us,
                           std::int64_t now_us) {
  const auto& [position, motion] = root;
  const typename JumpGuard<S>::Seen seen{position.north_m, position.east_m, motion.psi,
                                         motion.nu,        valid_us,        now_us};
  typename JumpGuard<S>::Seen compared = seen;
  bool near = true;
  if (held_ && guard_.last()) {  // the held one may have another plane
    const auto [apart_n, reaches] = convert::separation<S>(held_->root.position, position);
    near = reaches;
    compared.north_m = guard_.last()->north_m - apart_n.x;
    compared.east_m = guard_.last()->east_m - apart_n.y;
  }
  if (guard_.take(compared, !near) == JumpGuard<S>::Verdict::kRefused) return false;
  guard_.believe(seen);
  return true;
}

template <class S>
void Reference<S>::tell(const convert::RootState<S>& root, std::int64_t now_us) {
  if (held_ && now_us - held_->valid_us < kTold_us) return;
  if (const auto told = convert::reference_of(root)) {
    hold(mine(), ++made_, *told, root, now_us, true, true);
  }
}

template <class S>
void Reference<S>::tell(const core::Future<S>& future, std::int64_t begun_us) {
  auto told = convert::message_of(future);
  if (!told) return;
  told->sequence = static_cast<std::uint16_t>(future_ ? future_->told.sequence + 1 : 0);
  future_.emplace(mine(), *told, future, begun_us, true);
  ++future_news_;
}

/// Updates valid_us in every tick, because the leader's clock offset becomes more precise.
template <class S>
void Reference<S>::make(VesselTrack<S>& leader, std::int64_t now_us) {
  const auto message = leader.take_fix();
  if (leads_) return;
  walk(now_us);
  if (place_.branch(now_us)) {
    shapes_ = false;
    return;
  }
  if (message) shape(leader, *message);
  const auto age_us = leader.age_us(now_us);
  if (!age_us || !leader.has_origin()) return;
  if (!message) {
    if (!held_ || held_->branch != mine()) return;
    held_->valid_us = now_us - *age_us;
    held_->timed = leader.timed();
    return;
  }
  const convert::RootState<S> root{leader.position(),
                                   {shaped_.psi, shaped_.nu, shaped_.nu_dot, shaped_.nu_ddot.r}};
  if (const auto told = convert::reference_of(root)) {
    hold(mine(), ++made_, *told, root, now_us - *age_us, true, leader.timed());
  }
}

/// Starts from the leader's track: when a branch ends, the leader's motion is already known.
template <class S>
void Reference<S>::shape(const VesselTrack<S>& leader, const core::TrackMessage<S>& message) {
  if (std::exchange(shapes_, true)) {
    core::track_update(core::reference_track<S>(), shaped_, message);
  } else {
    shaped_ = leader.track();
  }
}

template <class S>
void Reference<S>::hold(const auto&... held) {
  held_.emplace(held...);
  walks_ = false;
  ++news_;
}

/// The reference of the current branch: the leader's, else our own.
template <class S>
const typename Reference<S>::Held* Reference<S>::held(std::int64_t now_us,
                                                      std::int64_t oldest_us) const {
  if (!on_ || !held_ || now_us - held_->valid_us > oldest_us) return nullptr;
  return held_->branch == place_.branch(now_us).value_or(mine()) ? &*held_ : nullptr;
}

template <class S>
std::optional<typename Reference<S>::Aim> Reference<S>::aim(std::int64_t now_us) const {
  const Held* held = this->held(now_us, lasting_us(now_us, kOldestFollowed_us));
  if (held == nullptr || !held->near || !held->timed) return std::nullopt;
  const auto& offset = place_.offset(now_us);
  if (!offset) return std::nullopt;
  if (walks_ && future_) {
    const S ahead = convert::seconds<S>(now_us - future_->begun_us) - walk_.t;
    return Aim{held->branch, held->root.position,
               core::future_motion(future_->future, walk_, ahead), *offset};
  }
  const S age = convert::seconds<S>(now_us - held->valid_us);
  return Aim{held->branch, held->root.position,
             core::reference_forward(limits_, held->root.motion, age), *offset};
}

template <class S>
std::optional<link::FormationReference> Reference<S>::message(std::int64_t now_us,
                                                              bool followed) const {
  const Held* held = this->held(now_us, lasting_us(now_us, kOldestTold_us));
  const auto& offset = place_.offset(now_us);
  if (held == nullptr || !offset || place_.too_deep(now_us)) return std::nullopt;
  link::FormationReference out = held->told;
  out.time_boot_ms = convert::boot_ms(now_us);
  out.age_ms = age_ms(now_us, held->valid_us);
  out.sequence = held->sequence;
  out.root = held->branch.root;
  out.maker = held->branch.maker;
  out.flags = followed ? link::mav::kReferenceFollowed : std::uint8_t{0};
  if (!held->timed) out.flags |= link::mav::kReferenceUntimed;
  out.offset_n = offset->n;
  out.path = place_.path(now_us);
  out.offset_b = offset->b;
  return out;
}

template <class S>
std::optional<link::FormationFuture> Reference<S>::future_message(std::int64_t now_us) const {
  const HeldFuture* told = on_ ? future(now_us) : nullptr;
  if (told == nullptr) return std::nullopt;
  link::FormationFuture out = told->told;
  out.time_boot_ms = convert::boot_ms(now_us);
  out.age_ms = age_ms(now_us, told->begun_us);
  out.root = told->branch.root;
  out.maker = told->branch.maker;
  return out;
}

template <class S>
std::optional<std::int64_t> Reference<S>::age_us(std::int64_t now_us) const {
  const Held* held = this->held(now_us, lasting_us(now_us, kOldestFollowed_us));
  const bool known = held != nullptr && held->timed;
  return known ? std::optional(now_us - held->valid_us) : std::nullopt;
}

template class Reference<float>;
template class Reference<double>;
template class Reference<core::Q16>;

}  // namespace flotilla::app
