// SPDX-License-Identifier: MIT
// Feeds the monitor of the boat's model with the propellers' impulses and the boat's motion.
#pragma once

#include <cstdint>
#include <utility>

#include "app/convert/convert_scalar.hpp"
#include "app/estimation/model_monitor.hpp"
#include "app/guidance/guidance.hpp"
#include "app/propulsion/can_node.hpp"

namespace flotilla::app {

template <class S>
class Learner {
 public:
  /// Both must outlive this.
  Learner(const Guidance<S>& guidance, const CanNode& can) : guidance_(guidance), can_(can) {}

  ModelMonitor& monitor() { return monitor_; }

  /// Call while the law does not drive, or the motion is unknown.
  void interrupt() {
    monitor_.interrupt();
    given_ = {};
  }

  /// One step, with the thrust given since the last one, dt s ago. True if the monitor's applied()
  /// has changed.
  [[nodiscard]] bool step(const core::Thrust<S>& thrust,
                          const Configuration::Propulsion& propulsion, S dt, std::int64_t now_us) {
    const core::AllocationParams<S>& propellers = guidance_.law().propellers;
    const core::Thrust<S> turning{turning_thrust(thrust.port, propulsion.port_esc),
                                  turning_thrust(thrust.stbd, propulsion.stbd_esc)};
    // Summed in the law's scalar: float is slow where a processor has none.
    core::impulse_forward(given_, core::wrench_of(propellers, turning), dt);
    if (given_.time < S(ModelMonitor::kSample_s)) return false;
    const auto of = [](S x) { return convert::in_float(x); };
    const auto [sum, time] = std::exchange(given_, {});
    const core::Motion<S>& motion = guidance_.motion();
    const auto [sin, cos] = core::sin_cos(motion.psi);
    const core::Vec2<S>& current_n = guidance_.current_n();
    return monitor_.take({{of(sum.X), of(sum.N)}, of(time)},
                         {of(motion.nu.u), of(motion.nu.v), of(motion.nu.r)}, {of(sin), of(cos)},
                         {of(current_n.x), of(current_n.y)}, now_us);
  }

 private:
  /// A propeller at rest in its dead band would look like drag, so it counts as without thrust. A
  /// propeller at rest at a greater thrust is stuck, and counts as weak.
  S turning_thrust(S thrust, std::uint8_t esc) const {
    const bool dead =
        can_.rests(esc) && core::abs(thrust) < S(0.125) * guidance_.law().propellers.F;
    return dead ? S(0) : thrust;
  }

  const Guidance<S>& guidance_;
  const CanNode& can_;
  ModelMonitor monitor_;
  core::Impulse<S> given_{};  // since the monitor last took one
};

}  // namespace flotilla::app
