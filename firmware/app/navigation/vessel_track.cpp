// SPDX-License-Identifier: MIT
#include "app/navigation/vessel_track.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace flotilla::app {
namespace {

constexpr std::int64_t kLongestRepeat_us = 1'000'000;  // between two states

/// Time to extrapolate a track over, s; capped at 10 s, as no older track is used.
template <class S>
S carried(std::int64_t us) {
  return convert::seconds<S>(std::min<std::int64_t>(us, 10'000'000));
}

}  // namespace

template <class S>
bool VesselTrack<S>::follow(std::uint8_t system, std::uint8_t only) {
  if (system == identity_.system && only == identity_.only) return false;
  VesselTrack next(identity_, antenna_);
  next.identity_.system = system;
  next.identity_.only = only;
  next.hold(held_);
  next.set_limits(guard_.limits());
  next.set_smoothing(filter_.smooths());
  next.set_lag(lag_us_);
  *this = next;
  return true;
}

template <class S>
void VesselTrack<S>::take_mine(const link::Message& message, const Arrival& arrival) {
  if (const auto* odometry = std::get_if<link::Odometry>(&message)) {
    take(*odometry, arrival);
  } else if (const auto* attitude = std::get_if<link::Attitude>(&message)) {
    take(*attitude, arrival);
  } else if (const auto* position = std::get_if<link::LocalPositionNed>(&message)) {
    take_joined(Source::kLocalPosition, *position, arrival);
  } else if (const auto* global = std::get_if<link::GlobalPositionInt>(&message)) {
    take_joined(Source::kGlobalPosition, *global, arrival);
  } else if (const auto* target = std::get_if<link::FollowTarget>(&message)) {
    take(*target, arrival);
  } else if (const auto* origin = std::get_if<link::GpsGlobalOrigin>(&message)) {
    take(*origin, arrival);
  }
}

template <class S>
void VesselTrack<S>::take(const link::Odometry& message, const Arrival& arrival) {
  const convert::Reading<S> reading = convert::sample_of<S>(message);
  if (reading.sample) {
    choose({Source::kOdometry, *reading.sample, message.reset_counter}, arrival);
  } else if (reading.refusal == convert::Refusal::kBadFrame) {
    ++arrival.counters.mavlink_bad_frame;
    frame_warning_ = true;
  } else {
    ++arrival.counters.mavlink_bad_value;
  }
}

template <class S>
void VesselTrack<S>::take(const link::Attitude& message, const Arrival& arrival) {
  using Verdict = typename Headings<S>::Verdict;
  const auto& [from, now_us, counters] = arrival;
  const auto sample = convert::heading_of<S>(message);
  if (!sample) {
    ++counters.mavlink_bad_value;
    return;
  }
  if (from == component()) namesake_.hear(message.time_boot_ms, now_us);
  const bool silent = stamps_.silent(now_us);
  const Verdict verdict = headings_.take(*sample, from, from == component(), silent, now_us);
  if (verdict == Verdict::kLate) ++counters.mavlink_old_stamp;
  if (verdict != Verdict::kLeapt) return;
  guard_.note_jump(now_us);
  ++counters.mavlink_jump;
}

template <class S>
void VesselTrack<S>::take(const link::FollowTarget& message, const Arrival& arrival) {
  if (!convert::is_usable(message)) {
    ++arrival.counters.mavlink_bad_value;
  } else if (const auto heading = convert::own_heading_of<S>(message)) {
    choose({Source::kFollowTarget, *convert::sample_of(message, *heading)}, arrival);
  } else {
    take_joined(Source::kFollowTarget, message, arrival);
  }
}

template <class S>
void VesselTrack<S>::take(const link::GpsGlobalOrigin& message, const Arrival& arrival) {
  if (!convert::is_valid(message)) {
    ++arrival.counters.mavlink_bad_value;
    return;
  }
  const bool in_use = component() == 0 || component() == arrival.component;
  // A local position is valid only with the origin that it was measured from.
  if (in_use && origins_.moves_to(message)) origin_changed();
  origins_.take(message, arrival.component, in_use, arrival.now_us);
  // A known plane is kept, so that the next position is compared with the last one.
  if (!in_use || plane_ || component() == 0) return;
  origins_.locate();
  if (origins_.located()) plane_ = origins_.position().origin;
}

/// A position joined with ATTITUDE's heading.
template <class S>
template <class Message>
void VesselTrack<S>::take_joined(Source source, const Message& message, const Arrival& arrival) {
  const auto& [from, now_us, counters] = arrival;
  const bool in_use = from == component();
  const Heading* heading = headings_.of(from, in_use);
  if (heading == nullptr) {
    ++counters.mavlink_no_heading;
    return;
  }
  const auto sample = convert::sample_of(message, heading->sample);  // its stamp near the heading's
  if (!sample) {
    ++counters.mavlink_bad_value;
    return;
  }
  const std::int64_t older_us = sample->stamp_us - heading->sample.stamp_us;
  if (std::abs(older_us) <= Headings<S>::kUsable_us) {
    choose({source, *sample, {}, heading, std::max<std::int64_t>(older_us, 0)}, arrival);
    return;
  }
  ++counters.mavlink_no_heading;
  if (!in_use || source != sources_.in_use() || reframed_) return;
  guard_.look_at(guard_.seen(origins_.in_plane(*sample), now_us), false);
}

/// Only the chosen source's state of the chosen component is accepted.
template <class S>
void VesselTrack<S>::choose(State state, const Arrival& arrival) {
  const auto& [from, now_us, counters] = arrival;
  const std::int64_t stamp_us = state.sample.stamp_us;
  if (from != component()) {
    if (!may_change(state.sample, arrival) || !judge_next(state, arrival)) return;
    component_changed(from, state.heading);
  }
  if (state.resets && sources_.is_reset(*state.resets, stamp_us)) {
    if (!judge_reset(state.sample, from, now_us)) guard_.note_moved(now_us);
    estimator_reset();
  }
  sources_.hear(state.source, stamp_us, now_us, stamps_.last_us().has_value());
  if (state.source != sources_.in_use()) {
    if (!sources_.better(state.source, now_us, origins_.is_told_by(from))) return;
    if (!judge_next(state, arrival)) return;
    if (const auto age = age_us(now_us)) state.resumed_us = now_us - *age;
    source_changed(state.source);
  }
  accept(state, arrival);
}

/// Whether the sender of this sample may become the component in use.
template <class S>
bool VesselTrack<S>::may_change(const convert::Sample<S>& sample, const Arrival& arrival) const {
  if (component() == 0) return true;
  const bool better = !origins_.located() && origins_.place_of(sample, arrival.component);
  const bool lost = identity_.one_link ? gone(arrival.now_us) : stamps_.silent(arrival.now_us);
  return !held_ && (better || lost);
}

/// Judges the first state of another component or source; true if it is plausible after the last
/// one. Counts a refusal; an accepted jump ends the motion.
template <class S>
bool VesselTrack<S>::judge_next(const State& state, const Arrival& arrival) {
  const auto& [from, now_us, counters] = arrival;
  const Jump jump = jump_across(state.sample, from, now_us);
  if (jump == Jump::kMoved) moved();
  if (jump == Jump::kRefused) ++counters.mavlink_jump;
  return jump != Jump::kRefused;
}

template <class S>
typename VesselTrack<S>::Jump VesselTrack<S>::jump_of(const convert::Sample<S>& sample,
                                                      const convert::Sample<S>& placed,
                                                      std::uint8_t from, std::int64_t now_us) {
  if (reframed_) return jump_across(sample, from, now_us);
  return guard_.take(guard_.seen(placed, now_us), origins_.is_far(sample));
}

/// Judges the first state after an estimator's reset; true if it can continue the track. It is
/// accepted at once in either case.
template <class S>
bool VesselTrack<S>::judge_reset(const convert::Sample<S>& sample, std::uint8_t from,
                                 std::int64_t now_us) {
  if (!guard_.last()) return true;
  const bool comparable = !reframed_ || (plane_ && origins_.place_of(sample, from));
  return comparable && jump_of(sample, origins_.in_plane(sample), from, now_us) == Jump::kGoesOn;
}

/// Compares a sample with the last state by their global positions, if both are known, whatever
/// their planes and clocks.
template <class S>
typename VesselTrack<S>::Jump VesselTrack<S>::jump_across(const convert::Sample<S>& sample,
                                                          std::uint8_t from, std::int64_t now_us) {
  const auto& last = guard_.last();
  if (!last) return Jump::kGoesOn;
  if (!plane_) {
    guard_.forget();
    return Jump::kGoesOn;
  }
  const auto place = origins_.place_of(sample, from);
  if (!place) return Jump::kGoesOn;
  const auto [n, near] = convert::separation<S>({last->north_m, last->east_m, *plane_}, *place);
  auto seen = guard_.seen(sample, now_us);
  seen.north_m = last->north_m - n.x;
  seen.east_m = last->east_m - n.y;
  seen.stamp_us = guard_.stamp_after_last(now_us);
  return guard_.take(seen, !near);
}

/// A sample of unknown global position does not replace the last known one in later comparisons.
template <class S>
void VesselTrack<S>::believe(const convert::Sample<S>& placed, std::int64_t now_us) {
  if (reframed_ && plane_ && guard_.last() && !origins_.located()) return;
  guard_.believe(guard_.seen(placed, now_us));
  if (!std::exchange(reframed_, false) && plane_.has_value() == origins_.located()) return;
  plane_.reset();
  if (origins_.located()) plane_ = origins_.position().origin;
}

template <class S>
void VesselTrack<S>::accept(const State& state, const Arrival& arrival) {
  using Stamp = StampFilter::Verdict;
  const auto& [from, now_us, counters] = arrival;
  const std::int64_t stamp_us = state.sample.stamp_us;
  const Stamp stamp = stamps_.judge(stamp_us, now_us, identity_.one_link);
  convert::Sample<S> placed = origins_.in_plane(state.sample);
  if (stamp == Stamp::kLate) {
    stamps_.refuse(stamp_us);
    if (!reframed_) guard_.look_at(guard_.seen(placed, now_us), true);
    ++counters.mavlink_old_stamp;
    return;
  }
  if (stamp == Stamp::kRestarted) rebooted(stamp_us);
  const bool far = origins_.is_far(state.sample);
  const Jump jump = jump_of(state.sample, placed, from, now_us);
  if (jump == Jump::kRefused) {
    ++counters.mavlink_jump;
    return;
  }
  if (jump == Jump::kMoved) {
    moved();
    if (stamp != Stamp::kNext) sources_.reset_clock();  // a jump: not just a late state
  } else if (stamp == Stamp::kWrapped) {
    rebooted(stamp_us);
  }
  // Regularly late states of a unit with one link mean that its clock was set back, unless TIMESYNC
  // contradicts that. Other vessels' states may instead have been overtaken on a faster link that
  // is now silent.
  if (identity_.one_link && stamps_.regularly_late() && !is_answered()) sources_.reset_clock();
  const bool moves = reframed_ && !state.sample.at;  // an anchor stays
  if (far || moves || !origins_.is_of_kind(state.sample)) {
    reframed_ = true;
    origins_.anchor(state.sample, from);
    placed = origins_.in_plane(state.sample);
  }
  update(state, placed, now_us);
}

template <class S>
void VesselTrack<S>::update(const State& state, convert::Sample<S>& placed, std::int64_t now_us) {
  const std::int64_t stamp_us = placed.stamp_us;
  const std::int64_t since_us = stamps_.last_us() ? stamp_us - *stamps_.last_us() : 0;
  believe(placed, now_us);
  ClockOffset& clock = sources_.clock();
  clock.heard(stamp_us, now_us);
  const std::int64_t true_us = stamp_us + clock.offset_us().value_or(0);
  // The stamps of two sources need not count from the same instant.
  const std::int64_t led_us =
      state.resumed_us ? std::max<std::int64_t>(true_us - *state.resumed_us, 1000) : since_us;
  liveness_.take(placed, convert::seconds<S>(std::min(led_us, kLongestRepeat_us)));
  convert::move_to_reference_point(placed, antenna_.x_m, antenna_.y_m);
  filter_.take({placed.psi_rad, convert::nu_of(placed), convert::seconds<S>(led_us)},
               state.resumed_us.has_value());
  origins_.put(placed.north_m, placed.east_m);
  stamps_.accept(stamp_us, state.heading_older_us, now_us);
  if (state.resets) sources_.note_resets(*state.resets);
}

template <class S>
void VesselTrack<S>::answered(link::Address from, std::int64_t sent_us, std::int64_t read_us,
                              std::int64_t now_us) {
  if (mine(from) && from.component == component()) sources_.answered(sent_us, read_us, now_us);
}

template <class S>
std::optional<std::int64_t> VesselTrack<S>::age_us(std::int64_t now_us) const {
  const auto stamp_us = stamps_.last_us(), offset = sources_.clock().offset_us();
  if (!stamp_us || !offset) return std::nullopt;
  // A state is at least as old as its arrival, whatever TIMESYNC has since made of its stamp.
  const std::int64_t true_us = std::min(*stamp_us + *offset, stamps_.arrived_us());
  return std::max<std::int64_t>(now_us - true_us, 0) + lag_us();
}

template <class S>
bool VesselTrack<S>::fresh(std::int64_t now_us, std::int64_t limit_us) const {
  const auto stamp_us = stamps_.last_us(), least = sources_.clock().least_us();
  if (!stamp_us || !least) return false;
  const std::int64_t worst_age_us = now_us - (*stamp_us + *least) + lag_us();
  return worst_age_us + stamps_.heading_older_us() < limit_us &&
         now_us - stamps_.arrived_us() < limit_us;
}

template <class S>
core::Motion<S> VesselTrack<S>::motion(std::int64_t now_us) const {
  return core::track_forward(filter_.track(), carried<S>(age_us(now_us).value_or(0)));
}

template <class S>
std::optional<double> VesselTrack<S>::uncertainty_m(std::int64_t now_us) const {
  const auto age = age_us(now_us);
  const auto least = sources_.clock().least_us(), offset = sources_.clock().offset_us();
  if (!age || !least || !offset) return std::nullopt;
  const S off = carried<S>(std::abs(*offset - *least));
  return convert::number(core::track_uncertainty(filter_.track(), carried<S>(*age), off));
}

template class VesselTrack<float>;
template class VesselTrack<double>;
template class VesselTrack<core::Q16>;

}  // namespace flotilla::app
