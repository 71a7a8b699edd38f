// SPDX-License-Identifier: MIT
// Sails a plan's identification voyage, which measures the hull. Begins when the plan reaches the
// voyage and the boat is in its room; locates the boat there by the navigation unit alone; judges
// whether the boat would leave the fence, or the circle round home, before it comes to rest.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "app/guidance/guidance.hpp"
#include "app/plan/fence.hpp"
#include "app/plan/voyage.hpp"

namespace flotilla::app {

template <class S>
class VoyageGuidance {
 public:
  /// Where the boat may sail.
  struct Bounds {
    const Fence& fence;
    float margin_m = 0;  ///< distance to keep from the fence
    std::optional<convert::GlobalPoint> home{};
    std::optional<float> reach_m{};  ///< from home
  };

  /// Call interrupt() when a state without voyages begins, begin_plan() when a plan begins at that
  /// item. If the item is an interrupted voyage, it then continues with the same step.
  void interrupt() { voyage_.interrupt(); }
  void begin_plan(const VoyageId& at);

  /// Begins a voyage if the item ahead is a voyage that is not over, and the boat is in its room.
  void begin(const PlanItem& ahead, const VoyageId& at, const Guidance<S>& guidance,
             const Configuration& configuration);

  bool is_on() const { return voyage_.is_on(); }
  bool is_over() const { return voyage_.is_over(); }
  bool is_lost() const { return voyage_.is_lost(); }
  std::size_t item() const { return voyage_.item(); }

  /// Judges whether the boat would leave its bounds if it stopped now; forward() uses the result and
  /// the greatest speeds.
  void look(const Guidance<S>& guidance, const Bounds& bounds, const VoyageSpeeds& fastest,
            std::int64_t now_us);

  /// Thrusts for the next dt seconds, N. centre: of the voyage's room.
  core::Thrust<S> forward(const Guidance<S>& guidance, const convert::GlobalPoint& centre,
                          bool waits, std::int64_t now_us, S dt);

  std::optional<VoyageNews> take_news() { return voyage_.take_news(); }

 private:
  HullVoyage<S> voyage_;
  bool at_fence_ = false;  // the last result of look()
};

}  // namespace flotilla::app
