// SPDX-License-Identifier: MIT
// Tracks one vessel, own or leader, by its MAVLink state messages.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "app/convert/convert.hpp"
#include "app/navigation/headings.hpp"
#include "app/navigation/jump_guard.hpp"
#include "app/navigation/liveness.hpp"
#include "app/navigation/motion_filter.hpp"
#include "app/navigation/namesake.hpp"
#include "app/navigation/origins.hpp"
#include "app/navigation/stamp_filter.hpp"
#include "app/navigation/state_sources.hpp"
#include "link/counters.hpp"

namespace flotilla::app {

/// Follows one system id by its first component whose global position is known, until that is
/// silent (with `one_link`: gone), and by the states that StateSources chooses: ODOMETRY,
/// LOCAL_POSITION_NED + ATTITUDE, FOLLOW_TARGET or GLOBAL_POSITION_INT + ATTITUDE. StampFilter
/// refuses late ones, JumpGuard implausible ones, except after an event that ends the track's
/// motion.
template <class S>
class VesselTrack {
 public:
  struct Identity {
    std::uint8_t system;
    std::uint8_t ignored_component;      ///< 0: none
    std::int64_t patience_us = 500'000;  ///< silence after which another source is chosen
    std::int64_t frozen_us = 700'000;    ///< repetition of one state that counts as frozen
    bool one_link = false;               ///< its states come over one link, of one component
    std::uint8_t only = 0;               ///< the only component; 0: any
  };
  struct Antenna {
    S x_m, y_m;
  };

  explicit VesselTrack(Identity identity, Antenna antenna = {S(0), S(0)})
      : identity_(identity),
        antenna_(antenna),
        sources_(identity.patience_us),
        liveness_(convert::seconds<S>(identity.frozen_us)) {}

  std::uint8_t system() const { return identity_.system; }

  /// Follows another vessel, or another of its components (0: any), and then discards everything
  /// known of the old one. False if it is the same.
  bool follow(std::uint8_t system, std::uint8_t only = 0);

  /// While held, no other component is chosen even if the one in use is silent.
  void hold(bool held) { held_ = held; }

  /// A state was accepted just now.
  bool accepted(std::int64_t now_us) const {
    return stamps_.last_us() && stamps_.arrived_us() == now_us;
  }
  /// Whether a message comes from the component whose states are accepted.
  bool is_from_unit(link::Address from) const {
    return mine(from) && from.component == component();
  }
  /// Changes whenever the latency of the states may have changed unnoticed.
  std::uint8_t clock_resets() const { return sources_.clock_resets(); }
  /// Nothing has been accepted for half a minute, longer than a unit needs to restart.
  bool gone(std::int64_t now_us) const { return now_us - stamps_.arrived_us() > 30'000'000; }

  void set_antenna(Antenna antenna) { antenna_ = antenna; }

  /// Latency of its states before arrival, used if TIMESYNC does not bound its clock; nothing:
  /// unknown.
  void set_lag(std::optional<std::int64_t> lag_us) { lag_us_ = lag_us; }
  bool bounded() const { return sources_.clock().was_answered(); }
  /// TIMESYNC has bounded its clock within the last minute.
  bool is_answered() const { return sources_.clock().is_answered(); }

  /// The age of its states is known, or there are none; otherwise age_us() counts from their
  /// arrival.
  bool timed() const {
    return bounded() || (lag_us_ && !sources_.clock().disputed()) || !stamps_.last_us();
  }

  /// This vessel's limits; the default is any vessel's.
  void set_limits(const core::PlausibilityLimits<S>& limits) { guard_.set_limits(limits); }

  /// Smoothing is for motion(). Without it each message replaces the estimate unfiltered: use that
  /// if another estimator knows the motion between messages better.
  void set_smoothing(bool smooths) { filter_.set_smoothing(smooths); }

  /// On: nobody follows its motion now, so it is filtered less often.
  void stand_by(bool stands_by) { filter_.stand_by(stands_by); }

  /// Change of velocity that the propellers alone would have caused since the last call, m/s.
  void push(S change_mps) { liveness_.push(change_mps); }

  /// Its state is not frozen.
  bool live() const { return liveness_.live(); }

  /// It has reported two different positions; until then it may be held in place.
  bool has_moved() const { return liveness_.moved(); }

  /// No implausible report within the last second.
  bool steady(std::int64_t now_us) const { return guard_.steady(now_us); }

  /// A jump was accepted since accept_place().
  bool jumped() const { return guard_.moved(); }
  void accept_place() { guard_.accept(); }

  /// Two vessels send ATTITUDE under this one's ids.
  bool doubled(std::int64_t now_us) const { return namesake_.seen(now_us); }

  /// Takes any message; ignores those of other vessels and unused types.
  void take(const link::Received& received, std::int64_t now_us, link::Counters& counters) {
    if (mine(received.from))
      take_mine(received.message, {received.from.component, now_us, counters});
  }

  /// The vessel answered a TIMESYNC request that we sent at `sent_us`.
  void answered(link::Address from, std::int64_t sent_us, std::int64_t read_us,
                std::int64_t now_us);

  /// Time since the state was true, not since its arrival; nothing if unknown.
  std::optional<std::int64_t> age_us(std::int64_t now_us) const;

  /// The state is known and younger than the limit, even at the clock's worst possible error.
  bool fresh(std::int64_t now_us, std::int64_t limit_us) const;

  /// Position at the last sample, from the origin of the sender's local frame, or, if it sends only
  /// global positions, from its first one.
  const convert::Position& position() const { return origins_.position(); }

  /// The position can be compared with other vessels'.
  bool has_origin() const { return component() != 0 && origins_.located(); }

  /// Motion extrapolated from the last sample; ages below zero count as zero.
  core::Motion<S> motion(std::int64_t now_us) const;

  /// The filter behind motion(), at the last sample.
  const core::TrackState<S>& track() const { return filter_.track(); }

  /// How far motion()'s position may be off, m; nothing if unknown.
  std::optional<double> uncertainty_m(std::int64_t now_us) const;

  /// The last message unless already taken; dt: since the last one taken, 0 if no motion led to it.
  std::optional<core::TrackMessage<S>> take_fix() { return filter_.take_fix(); }

  /// An ODOMETRY in a frame without north was refused since the last call.
  bool take_frame_warning() { return std::exchange(frame_warning_, false); }

 private:
  using Heading = typename Headings<S>::Heading;

  /// The sender and time of a message, and the counters for its errors.
  struct Arrival {
    std::uint8_t component;
    std::int64_t now_us;
    link::Counters& counters;
  };

  /// A state as received, from one message or joined with a heading.
  struct State {
    Source source;
    const convert::Sample<S>& sample;
    std::optional<std::uint8_t> resets{};  ///< of the estimator
    const Heading* heading = nullptr;
    std::int64_t heading_older_us = 0;
    std::optional<std::int64_t> resumed_us{};  ///< our time of the old source's state
  };

  bool mine(link::Address from) const {
    return from.system == identity_.system && from.component != identity_.ignored_component &&
           from.component != 0 && (identity_.only == 0 || identity_.only == from.component);
  }
  std::uint8_t component() const { return sources_.component(); }
  std::int64_t lag_us() const { return bounded() ? 0 : lag_us_.value_or(0); }

  void take_mine(const link::Message& message, const Arrival& arrival);
  void take(const link::Odometry& message, const Arrival& arrival);
  void take(const link::Attitude& message, const Arrival& arrival);
  void take(const link::FollowTarget& message, const Arrival& arrival);
  void take(const link::GpsGlobalOrigin& message, const Arrival& arrival);
  template <class Message>
  void take_joined(Source source, const Message& message, const Arrival& arrival);
  void choose(State state, const Arrival& arrival);
  bool may_change(const convert::Sample<S>& sample, const Arrival& arrival) const;
  bool judge_next(const State& state, const Arrival& arrival);
  using Jump = typename JumpGuard<S>::Verdict;
  Jump jump_of(const convert::Sample<S>& sample, const convert::Sample<S>& placed,
               std::uint8_t from, std::int64_t now_us);
  Jump jump_across(const convert::Sample<S>& sample, std::uint8_t from, std::int64_t now_us);
  bool judge_reset(const convert::Sample<S>& sample, std::uint8_t from, std::int64_t now_us);
  void believe(const convert::Sample<S>& placed, std::int64_t now_us);
  void accept(const State& state, const Arrival& arrival);
  void update(const State& state, convert::Sample<S>& placed, std::int64_t now_us);

  // Events that end a track or part of it. Besides them, follow() discards everything, and
  // jump_across() a last state whose plane is unknown.
  void component_changed(std::uint8_t component, const Heading* heading) {
    liveness_.forget_place();
    filter_.forget();
    other_sender();
    sources_.change_to(component);
    origins_.change_to(component);
    if (heading != nullptr) headings_.use(*heading);
  }
  /// The motion continues, with the new source's stamps and clock.
  void source_changed(Source source) {
    if (sources_.went_back(source)) origins_.forget(stamps_.arrived_us());
    other_sender();
    sources_.change_to(source);
  }
  void rebooted(std::int64_t stamp_us) {
    liveness_.forget_place();
    origins_.forget(stamps_.arrived_us());
    filter_.forget();
    other_sender();
    sources_.reboot(stamp_us);
  }
  void origin_changed() { reframed_ = true; }
  /// Another plane and clock apply; the last position remains the vessel's.
  void other_sender() { stamps_.forget(), reframed_ = true; }
  void estimator_reset() { motion_ended(); }
  void moved() { motion_ended(); }  ///< a jump was accepted
  /// No motion leads to the next state, which is accepted without comparison.
  void motion_ended() { guard_.forget(), stamps_.forget(), filter_.forget(); }

  Identity identity_;
  Antenna antenna_;
  std::optional<std::int64_t> lag_us_;
  StateSources sources_;
  StampFilter stamps_;
  Origins origins_;
  Headings<S> headings_;
  JumpGuard<S> guard_;
  Liveness<S> liveness_;
  Namesake namesake_;
  MotionFilter<S> filter_;
  std::optional<link::GpsGlobalOrigin> plane_;  // of the guard's last state, where it is known
  bool reframed_ = false;                       // that state is of another plane or clock
  bool held_ = false;
  bool frame_warning_ = false;
};

}  // namespace flotilla::app
