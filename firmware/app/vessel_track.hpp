// SPDX-License-Identifier: MIT
// What is known of one vessel, own or leader, from its MAVLink state messages.
#pragma once

#include <cstdint>
#include <optional>

#include "app/clock_offset.hpp"
#include "app/convert.hpp"
#include "link/counters.hpp"

namespace flotilla::app {

/// Follows one system id and of its components the lowest that sends whole states. ODOMETRY is
/// preferred to LOCAL_POSITION_NED + ATTITUDE while it comes. A message counts by its stamp: one
/// that is not younger than the last is refused, unless nothing younger has come for so long, and
/// the old stamps advance, that the vessel must have rebooted.
template <class S>
class VesselTrack {
 public:
  struct Identity {
    std::uint8_t system;
    std::uint8_t ignored_component;  ///< 0: none
  };
  struct Antenna {
    double x_m, y_m;
  };

  explicit VesselTrack(Identity identity, Antenna antenna = {0, 0})
      : identity_(identity), antenna_(antenna) {}

  /// Takes any message; those of other vessels and of no use here are passed over.
  void take(const link::Received& received, std::int64_t now_us, link::Counters& counters);

  /// The vessel answered a TIMESYNC request that we sent at `sent_us`.
  void answered(link::Address from, std::int64_t sent_us, std::int64_t read_us,
                std::int64_t now_us);

  /// Time since the state was true, not since it came; nothing where none is known.
  std::optional<std::int64_t> age_us(std::int64_t now_us) const;

  /// Its state is known and younger than the limit, at the worst that its clock may be off.
  bool fresh(std::int64_t now_us, std::int64_t limit_us) const;

  /// Position at the last sample; the origin is that of the sender's local frame.
  convert::Position position() const { return position_; }
  bool has_origin() const { return component_ != 0 && origin_component_ == component_; }

  /// Motion since the last sample; ages below zero count as zero.
  core::Motion<S> motion(std::int64_t now_us) const;

  /// The last message itself, and how many there have been.
  const core::TrackState<S>& last() const { return track_; }
  std::uint32_t messages() const { return messages_; }

  /// ODOMETRY in a frame without north was refused since the last call.
  bool take_frame_complaint();

 private:
  enum class Source : std::uint8_t { kOdometry, kLocalPosition };
  static constexpr std::int64_t kSilent_us = 1'000'000;
  static constexpr std::int64_t kSourceSilent_us = 300'000;

  struct Heading {
    std::uint8_t component = 0;
    convert::HeadingSample sample{};
  };

  bool mine(link::Address from) const;
  bool silent(std::int64_t now_us) const { return now_us - arrived_us_ > kSilent_us; }
  void take(const link::Odometry& message, std::uint8_t component, std::int64_t now_us,
            link::Counters& counters);
  void take(const link::Attitude& message, std::uint8_t component, std::int64_t now_us,
            link::Counters& counters);
  void take(const link::LocalPositionNed& message, std::uint8_t component, std::int64_t now_us,
            link::Counters& counters);
  void take(const link::GpsGlobalOrigin& message, std::uint8_t component, link::Counters& counters);
  bool chosen(std::uint8_t component, std::int64_t now_us);
  bool preferred(Source source, std::int64_t now_us);
  bool accept(convert::Sample sample, std::int64_t now_us, link::Counters& counters);
  void restart();

  Identity identity_;
  Antenna antenna_;
  std::uint8_t component_ = 0;
  Source source_ = Source::kLocalPosition;
  Heading heading_;        // of the chosen component
  Heading other_heading_;  // of another, which may be chosen when its position comes too
  std::optional<std::int64_t> stamp_us_;
  std::optional<std::int64_t> refused_stamp_us_;
  std::int64_t heading_older_us_ = 0;  // by how much the heading was older than the position
  std::int64_t arrived_us_ = 0;
  ClockOffset clock_;
  int refused_in_a_row_ = 0;
  std::uint32_t messages_ = 0;
  convert::Position position_;
  std::uint8_t origin_component_ = 0;
  bool frame_complaint_ = false;
  core::TrackState<S> track_;
};

}  // namespace flotilla::app
