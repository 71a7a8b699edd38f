// SPDX-License-Identifier: MIT
// The vessels around, as they tell by MAVLink, and which of them has the right of way.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "app/convert/convert.hpp"
#include "core/separation.hpp"

namespace flotilla::app {

/// A vessel is a system of which a component says in its heartbeat that it is a vehicle's autopilot;
/// that component's GLOBAL_POSITION_INT and FOLLOW_TARGET count, and its LOCAL_POSITION_NED and
/// ODOMETRY where it tells its origin. Virtual leaders, ground stations, companions and gimbals are
/// none. Of more than there is room for, the farthest are left out; one that is silent is forgotten.
class Neighbours {
 public:
  /// Our own system and our leader's. Nobody is tracked where `least_m`, FS_SEP_M, is 0.
  void configure(std::uint8_t own_system, std::uint8_t leader_system, float least_m);

  bool watches() const { return watches_; }

  /// Any message. Places are kept in the local frame of `own`. S: what is computed in.
  template <class S = double>
  void take(const link::Received& received, const convert::Position& own, std::int64_t now_us);

  /// Those around, carried forward to now, seen from `own` + `moved_n`.
  template <class S>
  core::Traffic<S> traffic(const convert::Position& own, const core::Vec2<S>& moved_n,
                           std::int64_t now_us) const;

  /// None of them is nearer than FS_SEP_M.
  template <class S>
  bool clear(const convert::Position& own, const core::Vec2<S>& moved_n, std::int64_t now_us) const;

  /// Links of the tree from a virtual leader, or from one that tells no depth of its own, to us.
  std::uint8_t depth() const;

 private:
  struct Vessel {
    std::uint8_t system = 0;  ///< 0: this place is free
    bool located = false;
    bool has_origin = false;
    bool steered = false;  ///< by itself: only then it may yield
    std::optional<std::uint8_t> depth;
    float v_north_mps = 0, v_east_mps = 0;
    Metres north_m, east_m;
    link::GpsGlobalOrigin origin{};  ///< of its local frame
    std::int64_t heard_us = 0;
  };

  void take_heartbeat(link::Address from, const link::Heartbeat& message);
  void take_depth(std::uint8_t system, const link::NamedValueFloat& message);
  void take_origin(std::uint8_t system, const link::GpsGlobalOrigin& message, std::int64_t now_us);
  template <class S>
  void take_place(std::uint8_t system, const convert::Sample<S>& sample,
                  const convert::Position& own, std::int64_t now_us);
  void look_from(const link::GpsGlobalOrigin& origin);
  Vessel* find(std::uint8_t system);
  Vessel* place_for(std::uint8_t system, std::optional<double> distance_m,
                    const convert::Position& own, std::int64_t now_us);
  bool has_way(const Vessel& vessel) const;

  std::uint8_t own_system_ = 0, leader_system_ = 0;
  float least_m_ = 0;
  bool watches_ = false;
  std::optional<std::uint8_t> leader_depth_;
  link::GpsGlobalOrigin frame_{};  // that all places are in
  std::array<Vessel, core::kMaxVessels> vessels_{};
  std::array<std::uint8_t, 256> autopilot_{};  // component, by system; 0: none was heard
};

}  // namespace flotilla::app
