// SPDX-License-Identifier: MIT
// Warns operators of faults, once a tick: of the host, the navigation unit, the slot, the fence,
// the water, the boat's own model. Remembers its warnings, so that it reports a fault when it
// begins, and again every 10 s or 30 s while it lasts. Decides nothing.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "app/debounced.hpp"
#include "app/estimation/model_monitor.hpp"
#include "app/guidance/guidance.hpp"
#include "app/operator/host_report.hpp"
#include "app/operator/vehicle.hpp"
#include "app/plan/fence_watch.hpp"
#include "app/sentence.hpp"

namespace flotilla::app {

template <class S>
class Warnings {
 public:
  /// The boat at the end of a tick.
  struct Seen {
    std::int64_t now_us = 0;
    core::State state = core::State::kDisarmed;
    core::Conditions conditions = 0;
    bool keeps_slot = false;
    const HostReport& host;
    const core::ControllerOutput<S>& law;
    const FenceWatch& fence;
  };

  /// All must outlive this.
  Warnings(Vehicle& vehicle, Guidance<S>& guidance, ModelMonitor& learnt, link::Counters& counters)
      : vehicle_(vehicle), guidance_(guidance), learnt_(learnt), counters_(counters) {}

  void warn(std::string_view text) { send_statustext(link::mav::kSeverityWarning, text); }

  void send(const Seen& seen);

  /// Reports once a boat out of its slot that the plan waits for; nothing: it waits for none.
  void tell_waiting(std::optional<std::uint8_t> late);
  /// Another plan begins.
  void forget_waiting() { awaited_.reset(); }

 private:
  static constexpr std::int64_t kSecond_us = 1'000'000;

  void send_statustext(std::uint8_t severity, std::string_view text) {
    vehicle_.texts().send(severity, {text}, counters_);
  }
  void warn_of_host(const Seen& seen);
  void warn_of_vessels(const Seen& seen);
  void warn_of_unit(const Seen& seen);
  void warn_of_time(const Seen& seen);
  void warn_of_fast_slot(const Seen& seen);
  void warn_of_station(const Seen& seen);
  void warn_of_current(const Seen& seen);
  void warn_of_unsound_slot(const Seen& seen);
  void warn_of_depth(const Seen& seen);
  void warn_of_fence(const Seen& seen);
  void tell_latency(const Seen& seen);
  void tell_finding(const Seen& seen);

  Vehicle& vehicle_;
  Guidance<S>& guidance_;
  ModelMonitor& learnt_;
  link::Counters& counters_;

  Schedule fence_due_{10 * kSecond_us}, frame_due_{10 * kSecond_us},
      fast_slot_due_{10 * kSecond_us};
  Schedule unsound_slot_due_{10 * kSecond_us}, no_headway_due_{10 * kSecond_us};
  Schedule double_due_{10 * kSecond_us}, late_due_{10 * kSecond_us}, quality_due_{10 * kSecond_us};
  Schedule not_to_arm_due_{30 * kSecond_us}, closed_due_{30 * kSecond_us},
      time_due_{30 * kSecond_us};
  Debounced slot_too_fast_, untimed_, no_headway_;  // no_headway_: against current or wind
  core::StationLoss station_loss_ = core::StationLoss::kNo;
  std::optional<std::uint8_t> awaited_;  // a boat
  bool save_failed_ = false;
  std::string_view unsaved_list_{};
  bool latency_told_ = false;
  bool deep_ = false;   // deeper in the tree than certified
  bool alone_ = false;  // sailed alone in the last tick
};

}  // namespace flotilla::app
