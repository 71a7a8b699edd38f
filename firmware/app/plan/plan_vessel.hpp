// SPDX-License-Identifier: MIT
// The virtual vessel that sails a plan or an errand: the paper's agent 0. A boat without a leader
// follows it by the law, and sends its motion as the formation's reference.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "app/plan/errand.hpp"
#include "app/plan/fence.hpp"
#include "core/drive.hpp"
#include "core/future.hpp"

namespace flotilla::app {

/// A plan or an errand, and where it begins.
struct PlanOrder {
  Plan plan{};
  std::size_t first = 0;         ///< begins with the first place at that item or later
  float start_m = kPlanStart_m;  ///< the farthest that this place may be from the boat
  std::optional<convert::GlobalPoint> home{};
  PlanProgress progress{};
  bool pauses = false;           ///< after an item whose autocontinue is 0
  bool voyage_is_over = false;   ///< the hull's voyage with which it begins
  const Fence* fence = nullptr;  ///< corners keep from it; it must outlive the plan's vessel
};

/// The boat that follows the vessel, off_m away from it. At far_m or more, the vessel waits.
template <class S>
struct BoatBehind {
  S off_m{};
  S far_m{};
  S most_mps{};  ///< LAW_U_MAX now, which may have been lowered under way; 0: no limit
};

/// Holds a few points of the plan at a time; the plan must not change between start() and the last
/// forward().
template <class S>
class PlanVessel {
 public:
  /// Starts at the boat's place and sails to the first point of the plan and on: at the boat's speed
  /// if that is more than `steerage` and nearly on course, otherwise from rest.
  void start(const PlanOrder& order, const PlanDefaults& defaults,
             const core::RouteParams<S>& limits, const convert::Position& own,
             const core::Motion<S>& motion, S steerage = S(0.1));

  /// Sails another plan from where the vessel is; if it must turn first, it goes on turning. Plans
  /// may change many times a second.
  void change(const PlanOrder& order, const PlanDefaults& defaults,
              const core::RouteParams<S>& limits);

  /// Sails for dt seconds; slows down and waits for the boat.
  void forward(Plan plan, const BoatBehind<S>& boat, bool paused, S dt);

  /// A future that followers should know, and the time since its beginning, s; returned once.
  struct Foreseen {
    core::Future<S> future;
    S since{};
  };
  std::optional<Foreseen> take_future();

  /// The vessel's motion from now on, every `every_s`, if it waits for nobody. Computes four steps
  /// of the planner for each second.
  void foresee(std::span<core::Motion<S>> motions, int every_s) const;

  /// Sails for dt seconds at these velocities; the plan is given up.
  void drive(const core::Drive<S>& desired, const BoatBehind<S>& boat, bool paused, S dt);

  /// Sails at this speed on all legs from now on.
  void set_speed(S mps) {
    for (core::Waypoint<S>& point : points_) point.speed = mps;
  }

  /// The plan begins near enough to the boat. False, too, once the vessel stands at the beginning
  /// of a leg that is longer than the planner's range.
  bool is_sound() const { return sound_ && !(is_at_end() && unread_); }
  bool has_arrived() const { return is_at_end() && !unread_; }

  /// The item whose place is ahead, or where the vessel waits or turns; the item where it started,
  /// if no place follows.
  PlanMark ahead() const {
    for (const std::size_t i : {state_.next, std::size_t{1}}) {
      if (marks_[i].is_item()) return marks_[i];
    }
    return first_;
  }
  std::size_t item() const { return ahead().item; }

  /// The item whose place was reached last, if any since the start.
  std::optional<std::size_t> reached() const;

  /// The DO_SET_HOME that follows that place; returned once.
  std::optional<std::size_t> take_home();
  /// Whether the vessel has left a place after which the plan pauses; true once.
  bool take_pause();

  /// Motion since the place where it started.
  const convert::Position& from() const { return from_; }
  const core::Motion<S>& motion() const { return state_.motion; }
  convert::Position place() const;

 private:
  static constexpr std::size_t kWindow = 12;  // more than the planner looks ahead

  core::Waypoints<S> points() const { return core::Waypoints<S>(points_).first(count_); }
  void fill(Plan plan);
  bool add(const PlanPoint& point);
  void round_less(const core::Vec2<S>& before, core::Waypoint<S>& corner,
                  const core::Vec2<S>& after) const;
  void move_base();
  bool is_under_way() const;
  std::size_t reached_point() const { return is_under_way() ? state_.next - 1 : state_.next; }
  bool is_at_end() const { return state_.phase == core::RoutePhase::kArrived; }
  void advance(core::RouteState<S>& state, S share, S dt) const;
  void look_ahead(S share, S dt);

  convert::Position from_;
  float start_m_ = 0;
  const Fence* fence_ = nullptr;
  float margin_m_ = 0;
  PlanMark first_;  // where it started
  core::RouteParams<S> limits_;
  PlanReader reader_;
  std::array<core::Waypoint<S>, kWindow> points_{};
  std::array<PlanMark, kWindow> marks_{};  // kNone: where it started
  std::size_t count_ = 1;
  core::RouteState<S> state_{};
  bool sound_ = false;
  bool unread_ = false;  // the next point is still too far away

  // The future is computed anew every second, a sample per tick, by sailing `scout_` ahead.
  core::RouteState<S> scout_{};
  Foreseen foreseen_{};
  std::size_t seen_ = 0;   // samples of foreseen_
  S share_{};              // of its speed, when the scout set out
  int untold_ = 0;         // successive futures without any change
  bool foresees_ = false;  // foreseen_ is whole, and not taken yet
};

}  // namespace flotilla::app
