// SPDX-License-Identifier: MIT
// The voyage that measures a hull: sails kVoyageSteps in open loop, within a circular room.
//
//   p_s = p + T_s v        where the boat comes to rest: |p_s| < 0.95 R, or the step is cut off
//   |p| > 0.4 R: back to 0.33 R before the next step; > 1.5 R: lost
//   |p| > 0.15 R: turns first, where the next step goes far
//   d = ±min(d_max, |k (χ_d − ψ) − k_r r|)      port = s + d, stbd = s − d      steers to a course
//
//  symbol    meaning                                                          unit
//  p, v      place from the room's centre, velocity over ground, north-east   m, m/s
//  R, T_s    radius of the room; time in which the boat comes to rest         m, s
//  χ_d, ψ    desired course, heading                                          rad
//  s, d      surge and differential, shares of a propeller's greatest thrust  1
//
// The control law is not used, because it needs the numbers that the voyage measures. To return to
// the centre between steps, the boat also uses shares of its thrust.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "app/plan/plan.hpp"
#include "app/plan/voyage_steps.hpp"
#include "core/allocation.hpp"

namespace flotilla::app {

/// Whether a plan's item is such a voyage.
bool is_voyage(const PlanItem& item);

/// Judges its parameters.
PlanFault fault_of_voyage(const PlanItem& item);

/// Tells a voyage from every other one, also from the same item sailed once more.
struct VoyageId {
  std::uint32_t round = 0;  ///< MissionService::round()
  std::size_t item = 0;
  std::uint16_t jumps = 0;  ///< taken before it
  bool operator==(const VoyageId&) const = default;
};

/// The place of a voyage, and its limits.
struct VoyageRoom {
  VoyageId id{};
  float radius_m = 0;
  float share = 0;   ///< greatest share of full thrust
  float rest_s = 0;  ///< stopping distance / speed
  bool operator==(const VoyageRoom&) const = default;
};

/// The greatest speeds of a voyage.
struct VoyageSpeeds {
  float mps = 0, radps = 0;
};
VoyageSpeeds speeds_of(const PlanDefaults& defaults);

/// The room that a voyage's item asks for.
VoyageRoom room_of(const PlanItem& item, const PlanDefaults& defaults,
                   const Configuration::Stopping& stopping);

/// News for the operator; see sentence_of().
struct VoyageNews {
  enum class Kind : std::uint8_t { kBegins, kAgain, kLeftOut, kOver, kLost };
  Kind kind = Kind::kBegins;
  std::size_t step = 0;     ///< from 1; kOver: how many were sailed whole
  std::string_view what{};  ///< the step's name, or why it was cut off
};

template <class S>
class HullVoyage {
 public:
  /// Motion relative to the centre, from the navigation unit alone: the model of the hull may be
  /// wrong.
  struct Seen {
    core::Vec2<S> off_n{}, velocity_n{};
    S psi{}, r{};
    bool waits = false;    ///< paused, or another vessel is too near: no thrust
    bool blocked = false;  ///< would leave the fence
  };

  /// Begins, or continues the same voyage with the step where it was interrupted.
  void begin(const VoyageRoom& room);
  /// Call after begin(), and when the speeds may have changed.
  void limit(const VoyageSpeeds& fastest);
  /// Stops; the step is sailed anew after begin().
  void interrupt();
  /// The next begin() starts with the first step.
  void forget() { *this = {}; }

  bool is_on() const { return phase_ != Phase::kOff; }
  /// The boat is too far outside its room: the voyage has ended.
  bool is_lost() const { return lost_; }
  bool is_of(const VoyageId& id) const { return room_.id == id; }
  bool is_over() const { return step_ == kVoyageSteps.size(); }
  std::size_t item() const { return room_.id.item; }
  const VoyageRoom& room() const { return room_; }

  /// Thrusts, shares of each propeller's greatest one, for the next dt seconds.
  core::Thrust<S> forward(const Seen& seen, S dt);

  std::optional<VoyageNews> take_news();

 private:
  enum class Phase : std::uint8_t { kOff, kRest, kReturn, kTurn, kDriven, kCoasting };

  const VoyageStep& step() const { return kVoyageSteps[step_]; }
  void enter(Phase phase);
  void begin_step(const Seen& seen);
  void end_step();
  void next_step();
  bool slow_down(S& factor);
  void cut_off(std::string_view why, bool slower);
  void look(const Seen& seen);
  void advance(const Seen& seen);
  void lose();
  core::Thrust<S> shares(const Seen& seen, S dt);
  core::Thrust<S> slowed(S port, S stbd) const;
  core::Thrust<S> steered(const Seen& seen, S surge) const;
  bool update_swapped(const Seen& seen, S dt);

  VoyageRoom room_{};
  Phase phase_ = Phase::kOff;
  bool lost_ = false;
  std::size_t step_ = 0, whole_ = 0;
  int tries_ = 0;
  S radius_{}, greatest_{}, gain_{};
  S ahead_ = S(1), turning_ = S(1);  // shares that are left after the boat was too fast
  S rest_s_{}, fastest_{}, fastest_r_{};
  S away_{};  // from the centre
  S in_phase_s_{};
  S course_{};
  bool swapped_ = false;
  S chip_s_{};
  unsigned register_ = 1;
  std::optional<VoyageNews> news_;
};

}  // namespace flotilla::app
