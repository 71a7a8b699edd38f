// SPDX-License-Identifier: MIT
// Watches a boat tick by tick: its input, its output, and the first rule that it breaks.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "app/boat/boat.hpp"
#include "policies/can_ear.hpp"
#include "policies/mavlink_ear.hpp"
#include "policies/moment.hpp"

namespace flotilla::policies {

struct Violation {
  std::string_view name;
  std::int64_t now_us;  ///< by the host's clock, as passed to ticked()
};

/// The first rule that does not hold; nothing if all do.
std::optional<std::string_view> first_broken(const Seen& before, const Moment& now);

/// Pass it all input of its boat, in the same order, and every tick:
///
///   boat.on_mavlink(bytes, now_us, link);    monitor.heard(bytes);
///   boat.on_can(id, data, now_us);           monitor.on_can(id, data);
///   const auto out = boat.tick(now_us);      monitor.ticked(boat, out, now_us);
template <class S>
class Monitor {
 public:
  /// p: the boat's initial parameters.
  explicit Monitor(const app::Parameters& p);

  /// The true clocks, where the simulation knows them; from the next heard() on.
  void know(const Clocks& clocks) { now_.clocks = clocks; }

  /// A link is limited to at most 5,760 bytes/s: TIMESYNC is requested there every 4 s.
  void know_slow_link() { now_.slow_link = true; }

  void heard(std::span<const std::uint8_t> bytes);
  void on_can(std::uint32_t can_id, std::span<const std::uint8_t> data) {
    can_.hear(can_id, data, known_, now_.heard);
  }

  /// `out`: result of tick(now_us). Returns a violation at this tick, if it is the boat's first.
  std::optional<Violation> ticked(const app::Boat<S>& boat,
                                  const typename app::Boat<S>::Output& out, std::int64_t now_us);

  /// The first violation.
  const std::optional<Violation>& broken() const { return broken_; }

 private:
  void look_inside(const app::Boat<S>& boat);
  void note_change(const app::Parameters& now);
  void note_damage(const link::Counters& counters);
  void note_times();
  void note_deeds();

  CanEar can_;
  MavlinkEar mavlink_;
  app::Parameters known_;  ///< in force
  Seen before_;
  Moment now_;
  std::uint32_t damage_ = 0;
  std::int64_t torn_until_us_ = kNever_us;
  bool torn_ = false;
  std::optional<Violation> broken_;
};

}  // namespace flotilla::policies
