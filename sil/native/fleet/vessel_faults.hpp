// SPDX-License-Identifier: MIT
// The faults of one vessel's navigation unit, bus and radio.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "fleet/fault.hpp"
#include "fleet/frame_writer.hpp"
#include "fleet/navigation_unit.hpp"
#include "fleet/radio_link.hpp"
#include "link/dronecan/can_frame.hpp"

namespace flotilla::fleet {

/// Times in µs: the vessel's clock if named now_us, else the world's.
class VesselFaults {
 public:
  using Bytes = std::vector<std::uint8_t>;

  void set(const Fault& fault);
  void clear(FaultKind kind);
  bool none() const { return active_.none(); }
  bool has(FaultKind kind) const { return active_[static_cast<std::size_t>(kind)]; }
  double value(FaultKind kind) const { return value_[static_cast<std::size_t>(kind)]; }

  /// The unit that sends under the ids of the vessel's unit.
  void set_impostor(NavigationUnit&& unit) { impostor_.emplace(std::move(unit)); }

  /// A second unit on the navigation link.
  void set_own_impostor(NavigationUnit&& unit) { own_impostor_.emplace(std::move(unit)); }
  void set_late_kind(NavigationUnit&& unit) { late_kind_.emplace(std::move(unit)); }

  /// Lets other vessels anchor ahead, for a fault of that kind. `origin`: of the units' frames.
  void anchor(const Fault& fault, const std::array<std::int32_t, 3>& origin);

  /// Appends the second units' output; call measured() first, which stores the true state.
  void send_beside(std::int64_t now_us, Bytes& out);

  /// The radio signal that others (vessels at anchor, an AIS receiver, a ground station) send to
  /// this vessel alone. `system`: its id. Call measured() first; valid until the next call.
  std::span<const std::uint8_t> sent_to(std::uint8_t system, std::int64_t now_us);

  /// Appends the frames of other nodes on the bus.
  void put_on_bus(std::int64_t now_us, std::vector<link::CanFrame>& out);

  /// The unit's measurement of the true state; valid until the next call.
  Sensed measured(const Sensed& truth);

  /// Offset of the unit's clock from the vessel's.
  std::int64_t unit_ahead_us() const;

  /// Whether the next frame, in either direction, passes the bus.
  bool passes_bus();

  /// The radio signal when the vessel sends `sent`; valid until the next call.
  std::span<const std::uint8_t> aired(std::span<const std::uint8_t> sent, std::int64_t t_us,
                                      std::int64_t now_us);

  /// A chunk as the vessel receives it: empty, or valid until the next call.
  std::span<const std::uint8_t> heard(std::span<const std::uint8_t> chunk);

 private:
  struct Pose {
    std::array<double, 3> eta, nu;
    std::array<std::int32_t, 2> degE7;
    Sensed sensed() const { return {eta.data(), nu.data(), degE7}; }
  };
  struct Said {
    std::int64_t t_us;
    Bytes data;
  };
  struct Anchored {
    FaultKind kind;
    NavigationUnit unit;
    double ahead_m, lasts_s;         // falls silent after that time
    std::optional<Pose> place = {};  // from its first message on
    std::int64_t since_us = 0;
  };

  static constexpr double kShipRate_Hz = 1.0 / 180;

  void weigh(FaultKind kind);  // the anchors of that fault
  Pose ahead(double by_m) const;
  void report_ship();
  void override_at_rest(std::uint8_t system);
  bool strikes(FaultKind kind);
  bool passes_radio();
  void damage(std::span<std::uint8_t> bytes);
  void send_again(std::span<const std::uint8_t> sent, std::int64_t t_us);

  std::bitset<kFaultKinds> active_;
  std::array<double, kFaultKinds> value_{};
  std::array<SplitMix64, kFaultKinds> random_{make_random()};
  Pose truth_{}, told_{};
  std::optional<Pose> frozen_;
  std::optional<NavigationUnit> impostor_, own_impostor_, late_kind_;
  std::vector<Anchored> anchored_;
  std::array<std::int32_t, 3> origin_{};
  std::optional<Pose> ship_;  // from its first report on
  FrameWriter ais_{{251, 191}}, ground_station_{{255, 190}};
  Rate button_rate_{10.0}, ship_rate_{kShipRate_Hz}, override_rate_{20.0};
  std::uint8_t button_id_ = 0;
  std::deque<Said> to_repeat_;
  Bytes aired_, heard_, others_;

  static std::array<SplitMix64, kFaultKinds> make_random();
};

}  // namespace flotilla::fleet
