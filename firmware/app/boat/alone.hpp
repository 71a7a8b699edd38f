// SPDX-License-Identifier: MIT
// Sails without a leader. AUTO sails the stored plan, including voyages that measure the hull.
// GUIDED sails to a target or by velocities, LOITER to a stop, RTL home or to a rally point,
// straight or round the zones that the fence forbids. A boat that was pushed aside searches for a
// new path.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "app/boat/conditions.hpp"
#include "app/guidance/voyage_guidance.hpp"
#include "app/operator/telemetry/warnings.hpp"
#include "app/operator/vehicle.hpp"
#include "app/plan/errands.hpp"

namespace flotilla::app {

template <class S>
class Alone {
 public:
  /// The boat in a tick. state: one in which it sails alone.
  struct Now {
    core::State state;
    core::Conditions conditions;
    std::int64_t now_us;
    bool shape_moves = false;  ///< the fleet's table moves its shape
  };

  /// All must outlive this.
  Alone(Vehicle& vehicle, Guidance<S>& guidance, FailsafeLimits& limits, Warnings<S>& warnings,
        link::Counters& counters)
      : vehicle_(vehicle),
        guidance_(guidance),
        limits_(limits),
        warnings_(warnings),
        counters_(counters) {}

  /// Call on entering the state.
  void start(const Now& now);

  /// One step, dt after the last one, s.
  core::ControllerOutput<S> sail(const Now& now, S dt);

  /// Before AUTO: judges the path from the boat to the plan's beginning, ten times a second.
  void check_way(const convert::Position& here, std::int64_t now_us);

  /// Once a second while home is too far away: looks for a rally point to return to.
  void look_for_rally(const convert::Position& here, std::int64_t now_us);

  bool rally_is_near() const { return rally_near_; }
  bool voyage_is_lost() const { return voyage_.is_lost(); }

 private:
  void start_plan(std::int64_t now_us);
  void start_errand(const Now& now, bool anew);
  void sail_back(const Target& meanwhile);
  convert::GlobalPoint return_place(const convert::Position& here,
                                    const convert::GlobalPoint& home) const;
  void sail_round(const Target& target, const Target& meanwhile);
  void sail_errand();
  PlanOrder errand() const { return {errands_.plan(), 0, kErrandReach_m}; }
  void keep_fence(const Now& now);
  void look_again();
  bool leg_keeps_fence() const;
  bool is_free(const convert::GlobalPoint& ahead) const;
  void tell_way();
  void change_speed(float speed_mps);
  core::ControllerOutput<S> sail_guided(const Now& now, S dt);
  core::ControllerOutput<S> sail_plan(const Now& now, S dt);
  void pause_plan(std::int64_t now_us);
  core::ControllerOutput<S> sail_items(const Now& now, S dt);
  core::ControllerOutput<S> sail_voyage(const Now& now, S dt);
  std::optional<convert::GlobalPoint> home() const;
  const Configuration& configuration() const { return vehicle_.configuration(); }

  Vehicle& vehicle_;
  Guidance<S>& guidance_;
  FailsafeLimits& limits_;
  Warnings<S>& warnings_;
  link::Counters& counters_;

  Errands errands_;              // of GUIDED, LOITER, RTL
  bool driven_ = false;          // by velocities, in GUIDED
  std::optional<Target> asked_;  // target of GUIDED, if one was asked for
  std::uint8_t lost_s_ = 0;      // since no way was found; 0: the operator was not told
  VoyageGuidance<S> voyage_;     // of AUTO
  Schedule way_due_{100'000};
  Schedule leg_due_{1'000'000}, rally_due_{1'000'000};
  bool rally_near_ = false;
};

}  // namespace flotilla::app
