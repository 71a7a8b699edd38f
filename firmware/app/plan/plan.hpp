// SPDX-License-Identifier: MIT
// A plan as a ground station sent it, item by item, and the meaning of its items for a boat.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "app/convert/convert.hpp"
#include "app/parameters/configuration.hpp"

namespace flotilla::app {

/// Values as received, so that a download repeats them bit for bit; without padding.
struct PlanItem {
  std::array<float, 4> param{};
  std::int32_t x = 0, y = 0;  ///< latitude and longitude, degE7, if the command has a place
  float z = 0;
  std::uint16_t command = 0;
  std::uint8_t frame = 0, autocontinue = 0;
};
static_assert(sizeof(PlanItem) == 32);

/// An item's parameter; those that are not used are NaN.
inline float or_zero(float param) { return std::isnan(param) ? 0.0F : param; }

using Plan = std::span<const PlanItem>;

/// Speed and radius where the plan gives none, and the greatest speed that it may ask for.
using PlanDefaults = Configuration::Plan;

/// All places of a plan lie within this distance of the first one.
constexpr float kPlanReach_m = 2000;
/// The longest leg from one place of a plan, or a circle round it, to the next.
constexpr float kPlanLeg_m = 2900;
/// The farthest that a boat may be from the place where its plan begins.
constexpr float kPlanStart_m = 1000;
/// No plan asks for a greater speed.
constexpr float kPlanFastest_mps = 5;

/// Longest wait at one place, also the sum of several: Q16.16 reaches to 32,767.
constexpr float kLongestWait_s = 30'000;

/// Whether a MAV_FRAME is global. Altitudes are ignored, whatever they refer to.
bool is_global(std::uint8_t frame);

/// Whether a boat may be asked for that speed.
bool is_speed(double mps, const PlanDefaults& defaults);

/// Why a plan, a fence or rally points are refused.
struct PlanFault {
  std::uint8_t result = link::mav::kMissionAccepted;  ///< MAV_MISSION_RESULT
  std::string_view why{};
  std::size_t item = 0;
  explicit operator bool() const { return result != link::mav::kMissionAccepted; }
};

/// Judges an item's frame and its place on the globe.
PlanFault fault_of_place(const PlanItem& item);

/// Judges whether an item's place is near enough to that of the first.
PlanFault fault_of_reach(const PlanItem& first, const PlanItem& item);

/// The place to which an item leads; nothing if it names none, or means the boat's position at that
/// time.
std::optional<convert::GlobalPoint> place_of(const PlanItem& item);

/// How far from its place an item leads the boat, m; 0: not beyond it.
float extent_of(const PlanItem& item, const PlanDefaults& defaults);

/// A corner of the octagon round a circle, where the boat enters, turns or leaves; 0 … 7, clockwise
/// from the north.
convert::GlobalPoint corner_of(const PlanItem& item, const PlanDefaults& defaults,
                               std::size_t octant);

/// The item to which a jump leads.
std::size_t jump_of(const PlanItem& item, const PlanDefaults& defaults);

/// The place that an item makes home; nothing: the boat's position at that time.
std::optional<convert::GlobalPoint> home_of(const PlanItem& item);

/// Judges the last item of a plan whose other items are sound.
PlanFault fault_of_last(Plan plan, const PlanDefaults& defaults);

/// Judges a whole plan whose items are each sound.
PlanFault fault_of(Plan plan);

/// How the items that a boat has passed affect the rest of its plan.
class PlanProgress {
 public:
  static constexpr std::size_t kJumps = 4;  ///< in a plan

  /// Executes the item if it is a jump or a speed; returns the number of the item that follows.
  std::size_t pass(Plan plan, std::size_t item);

  /// Goes to an item directly, with the speed that the items before it set. anew: no jump counts as
  /// taken.
  void go_to(Plan plan, std::size_t item, bool anew);

  /// The speed that the plan has set; 0: none.
  float speed_mps() const { return speed_mps_; }
  /// Jumps taken, modulo 65,536.
  std::uint16_t jumps() const { return taken_; }

 private:
  struct Jump {
    std::uint16_t item = 0;
    std::int16_t taken = -1;  // times; −1: free
  };

  void note_speed(const PlanItem& item);
  bool take_jump(const PlanItem& item, std::size_t at);

  std::array<Jump, kJumps> jumps_{};
  std::uint16_t taken_ = 0;
  float speed_mps_ = 0;
};

/// An item, and the jumps taken on the way to it, modulo 65,536.
struct PlanMark {
  static constexpr std::uint16_t kNone = 0xFFFF;
  std::uint16_t item = kNone, jumps = 0;
  std::uint16_t home = kNone;  ///< a DO_SET_HOME between this item's place and the next one
  bool pauses = false;         ///< the plan pauses before it leads to the next place
  bool is_item() const { return item != kNone; }
};

/// A point where the plan leads, and what happens there.
struct PlanPoint {
  PlanMark mark{};  ///< the item that names the place
  convert::GlobalPoint place{};
  float speed_mps = 0;  ///< on the way there
  float radius_m = 0;   ///< how far the rounded corner may pass from it
  float wait_s = 0;     ///< 0: does not stop
};

/// Where and how the reading of a plan begins.
struct PlanStart {
  std::size_t first = 0;        ///< item
  convert::GlobalPoint here{};  ///< the boat's place; it waits here if that item is a wait
  std::optional<convert::GlobalPoint> home{};  ///< unknown: NAV_RETURN_TO_LAUNCH ends the plan
  PlanProgress progress{};
  bool pauses = false;          ///< after an item whose autocontinue is 0
  bool voyage_is_over = false;  ///< the voyage with which the reading begins
};

/// Reads the points of a sound plan in order.
class PlanReader {
 public:
  void begin(const PlanStart& start, const PlanDefaults& defaults);

  /// The next point; nothing after the last. A voyage that measures the hull ends the reading,
  /// unless the reading begins with it and it is over: how the plan continues is decided then.
  std::optional<PlanPoint> next(Plan plan);

 private:
  PlanMark mark() const { return {static_cast<std::uint16_t>(at_), progress_.jumps()}; }
  float speed_mps() const;
  PlanPoint point_of(const PlanItem& item, const convert::GlobalPoint& place);
  PlanPoint on_circle(const PlanItem& item);
  void pass(Plan plan, std::optional<PlanPoint>& point);

  PlanDefaults defaults_;
  std::size_t at_ = 0;  // item
  PlanProgress progress_;
  std::optional<convert::GlobalPoint> home_;
  convert::GlobalPoint last_{};
  std::uint16_t octants_ = 0, octant_ = 0;  // of a circle: covered; the present one, from the north
  bool pauses_ = false, voyage_is_over_ = false;
};

}  // namespace flotilla::app
