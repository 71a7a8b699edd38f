// SPDX-License-Identifier: MIT
// Tracks one vessel, own or leader, by its MAVLink state messages.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "app/convert/convert.hpp"
#include "app/navigation/jump_guard.hpp"
#include "app/navigation/liveness.hpp"
#include "app/navigation/state_sources.hpp"
#include "link/counters.hpp"

namespace flotilla::app {

/// Follows one system id, and its lowest component that sends whole states: ODOMETRY,
/// LOCAL_POSITION_NED + ATTITUDE, FOLLOW_TARGET or GLOBAL_POSITION_INT + ATTITUDE, as StateSources
/// chooses. A message with a stamp not newer than the last is refused, unless nothing newer has
/// come for 1 s while the old stamps advance: then the vessel has rebooted. An implausible jump is
/// ignored until reported consistently for 1 s, except after a reboot, a reset of the estimate, or
/// a change of source or origin.
template <class S>
class VesselTrack {
 public:
  struct Identity {
    std::uint8_t system;
    std::uint8_t ignored_component;      ///< 0: none
    std::int64_t patience_us = 500'000;  ///< silence after which another source is chosen
    std::int64_t frozen_us = 700'000;    ///< repetition of one state that counts as frozen
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

  /// Follows another vessel; discards everything known of the old one.
  void follow(std::uint8_t system);

  void set_antenna(Antenna antenna) { antenna_ = antenna; }

  /// Latency of its states before arrival, used if TIMESYNC does not bound its clock.
  void set_lag(std::int64_t lag_us) { lag_us_ = lag_us; }
  bool bounded() const { return clock().was_answered(); }

  /// This vessel's limits; the default is any vessel's.
  void set_limits(const core::PlausibilityLimits<S>& limits) { guard_.set_limits(limits); }

  /// Smoothing is for motion(); off if another estimator knows the motion between messages better:
  /// then each message is believed as it is.
  void set_smoothing(bool smooths);

  /// Change of velocity that the propellers alone would have caused since the last call, m/s.
  void push(S change_mps) { liveness_.push(change_mps); }

  /// Its state is not frozen.
  bool live() const { return liveness_.live(); }

  /// It has reported two different positions; until then it may be held in place.
  bool has_moved() const { return liveness_.moved(); }

  /// No implausible report within the last second.
  bool steady(std::int64_t now_us) const { return guard_.steady(now_us); }

  /// Takes any message; ignores those of other vessels and unused types.
  void take(const link::Received& received, std::int64_t now_us, link::Counters& counters) {
    if (mine(received.from)) take_mine(received, now_us, counters);
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
  convert::Position position() const { return position_; }

  /// The position can be compared with other vessels'.
  bool has_origin() const { return component_ != 0 && (anchored_ || origin_known()); }

  /// The motion at the last sample.
  const core::TrackState<S>& track() const { return track_; }

  /// Motion extrapolated from the last sample; ages below zero count as zero.
  core::Motion<S> motion(std::int64_t now_us) const;

  /// How far motion()'s position may be off, m; nothing if unknown.
  std::optional<double> uncertainty_m(std::int64_t now_us) const;

  /// The last message unless already taken; dt: since the last one taken, 0 if no motion led to it.
  std::optional<core::TrackMessage<S>> take_fix() { return std::exchange(fix_, std::nullopt); }

  /// Number of messages accepted.
  std::uint32_t messages() const { return messages_; }

  /// An ODOMETRY in a frame without north was refused since the last call.
  bool take_frame_complaint();

 private:
  static constexpr std::int64_t kSilent_us = 1'000'000, kLeap_us = 600'000'000;

  struct Heading {
    std::uint8_t component = 0;
    convert::HeadingSample<S> sample{};
    std::int64_t arrived_us = 0;
  };

  bool mine(link::Address from) const {
    return from.system == identity_.system && from.component != identity_.ignored_component &&
           from.component != 0;
  }
  bool silent(std::int64_t now_us) const { return now_us - arrived_us_ > kSilent_us; }
  bool origin_known() const { return origin_component_ == component_; }
  void take_mine(const link::Received& received, std::int64_t now_us, link::Counters& counters);
  void take(const link::Odometry& message, std::uint8_t component, std::int64_t now_us,
            link::Counters& counters);
  void take(const link::Attitude& message, std::uint8_t component, std::int64_t now_us,
            link::Counters& counters);
  void take(const link::FollowTarget& message, std::uint8_t component, std::int64_t now_us,
            link::Counters& counters);
  template <class Message>
  void take_joined(Source source, const Message& message, std::uint8_t component,
                   std::int64_t now_us, link::Counters& counters);
  void take(const link::GpsGlobalOrigin& message, std::uint8_t component, link::Counters& counters);
  bool chosen(std::uint8_t component, std::int64_t now_us);
  bool preferred(Source source, std::int64_t stamp_us, std::int64_t now_us);
  void change_to(Source source, std::int64_t now_us);
  bool accept(const convert::Sample<S>& sample, std::int64_t now_us, link::Counters& counters);
  bool is_late(const convert::Sample<S>& sample, std::int64_t now_us);
  void moved(std::int64_t stamp_us, std::int64_t now_us);
  void update(const convert::Sample<S>& sample, std::int64_t now_us);
  convert::Sample<S> here(const convert::Sample<S>& sample) const;
  void anchor(const convert::Sample<S>& sample);
  void rebooted(std::int64_t stamp_us);
  void jumped();
  void restart();

  std::int64_t lag_us() const { return bounded() ? 0 : lag_us_; }
  ClockOffset& clock() { return sources_.clock(); }
  const ClockOffset& clock() const { return sources_.clock(); }

  Identity identity_;
  Antenna antenna_;
  std::int64_t lag_us_ = 0;
  std::uint8_t component_ = 0;
  StateSources sources_;
  JumpGuard<S> guard_;
  Liveness<S> liveness_;
  Heading heading_;        // of the chosen component
  Heading other_heading_;  // of another, which is chosen once its position comes too
  std::optional<std::uint8_t> odometry_resets_;
  std::optional<std::int64_t> stamp_us_;
  std::optional<std::int64_t> refused_stamp_us_;
  std::optional<std::int64_t> other_source_us_;  // our time of the previous source's state
  std::int64_t heading_older_us_ = 0;            // age of the heading at the position's stamp
  std::int64_t arrived_us_ = 0;
  int refused_in_a_row_ = 0;
  std::uint32_t messages_ = 0;
  convert::Position position_;
  bool anchored_ = false;  // position_.origin was chosen for global positions
  link::GpsGlobalOrigin origin_{};
  std::uint8_t origin_component_ = 0;  // 0: no origin received
  bool frame_complaint_ = false;
  bool smooths_ = true;
  core::TrackState<S> track_;
  std::optional<core::TrackMessage<S>> fix_;
};

}  // namespace flotilla::app
