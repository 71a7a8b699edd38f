// SPDX-License-Identifier: MIT
// A navigation unit's MAVLink side: sends a state, its origin and heartbeats, answers TIMESYNC.
// Counterpart of sil/wire/navigation_unit.py in the live SIL, byte for byte.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "fleet/clock.hpp"
#include "fleet/frame_writer.hpp"

namespace flotilla::fleet {

enum class StateMessage : std::uint8_t { kLocal, kOdometry, kGlobal, kFollowTarget };

struct UnitSettings {
  double rate_hz;
  StateMessage message;
  double attitude_rate_hz;             ///< 0: with every position
  std::array<std::int32_t, 3> origin;  ///< latitude, longitude (degE7), altitude (mm)
  double delay_s = 0;                  ///< latency of its own messages
  bool timesync = true;                ///< answers TIMESYNC, without that latency
  double dropout_every_s = 0;          ///< period by its clock; 0: never
  double dropout_s = 0;                ///< duration without a state
  bool vehicle = false;                ///< its HEARTBEAT is a boat's
};

/// A unit's measurement, in the frame that it reports: x y ψ (m, rad), u v r (m/s, rad/s); degE7.
struct Sensed {
  const double* eta;
  const double* nu;
  std::array<std::int32_t, 2> degE7;
};

/// Times are by its own clock, µs.
class NavigationUnit {
 public:
  NavigationUnit(link::Address self, const UnitSettings& settings);

  /// Appends the messages due to `out`.
  void tick(std::int64_t now_us, const Sensed& sensed, std::vector<std::uint8_t>& out);

  /// Takes any bytes; the next tick answers TIMESYNC requests to this unit.
  void on_mavlink(std::span<const std::uint8_t> data, std::int64_t now_us);

  /// From now on it also sends GPS_RAW_INT, with or without a fix.
  void tell_fix(bool good) { faulty().fix = good; }

  /// From now on it also sends ESTIMATOR_STATUS: good, or poor once and then of unknown accuracy.
  void tell_estimate(bool good) { faulty().accuracy_m = good ? kGood_m : kPoor_m; }

  /// From now on it also sends RC_CHANNELS: the throttle's share of full deflection while the pilot
  /// has the switch on, else everything at rest.
  void tell_pilot(std::optional<double> throttle) { faulty().pilot = Pilot{throttle}; }

  bool tells_degrees() const { return settings_.message >= StateMessage::kGlobal; }
  const UnitSettings& settings() const { return settings_; }
  link::Address self() const { return self_; }

 private:
  struct Request {
    std::int64_t ts1_ns;
    std::int64_t arrived_us;
  };
  struct Pilot {
    std::optional<double> throttle;
  };
  static constexpr float kGood_m = 0.5F, kPoor_m = 500;
  /// Extra output of a unit from its first fault on.
  struct Faulty {
    Rate fix_rate{5.0}, pilot_rate{20.0};
    std::optional<bool> fix;
    std::optional<float> accuracy_m;
    std::optional<Pilot> pilot;
  };
  using Out = std::vector<std::uint8_t>;
  struct Waiting {
    std::int64_t since_us;
    Out frames;
  };

  void answer(Out& out);
  void tell_due(std::int64_t now_us, const Sensed& sensed, Out& out);
  bool drops_out(std::int64_t now_us) const;
  void tell_slowly(std::int64_t now_us, Out& out);
  void tell(std::int64_t now_us, const Sensed& sensed, Out& out);
  void attitude(std::int64_t now_us, const Sensed& sensed, Out& out);
  void local(std::int64_t now_us, const Sensed& sensed, Out& out);
  void odometry(std::int64_t now_us, const Sensed& sensed, Out& out);
  void global(std::int64_t now_us, const Sensed& sensed, Out& out);
  void follow_target(std::int64_t now_us, const Sensed& sensed, Out& out);
  Faulty& faulty();
  void fix(std::int64_t now_us, Out& out);
  void estimate(std::int64_t now_us, Out& out);
  void pilot(std::int64_t now_us, Out& out);
  void take_timesync(std::span<const std::uint8_t> frame, const link::FrameHeader& header,
                     std::int64_t now_us);

  link::Address self_;
  UnitSettings settings_;
  FrameWriter writer_;
  Rate state_rate_, slow_rate_;
  std::unique_ptr<Faulty> faulty_;  // few units have one
  std::optional<Rate> attitude_rate_;
  std::vector<Request> requests_;
  std::int64_t delay_us_, every_us_, dropout_us_;
  std::vector<Waiting> waiting_;  // few; a deque is half a kilobyte
};

}  // namespace flotilla::fleet
