// SPDX-License-Identifier: MIT
// Tracks nearby vessels by their MAVLink messages or AIS, and decides which have the right of way.
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "app/convert/convert.hpp"
#include "core/separation.hpp"

namespace flotilla::app {

/// A vessel is a system with a component whose heartbeat announces a vehicle's autopilot; that
/// component's GLOBAL_POSITION_INT and FOLLOW_TARGET count, and, if its origin is known, its
/// LOCAL_POSITION_NED and ODOMETRY, even if they report only its position. Virtual leaders, ground
/// stations, companions and gimbals do not count. When full, keeps the vessels that come nearest;
/// forgets silent ones.
///
/// Two vessels with one system id have two entries while they are far enough apart.
///
/// The delay of a state beyond that of the vessel's promptest messages adds to its age, up to 30 s.
/// The delay that all its messages share is not measured, but assumed to be 0.1 s.
///
/// AIS_VESSEL counts from any component, under the ship's MMSI, for 30 s, because ships report
/// every two to ten seconds; or for 6.5 min if the ship rests, because it then reports every three
/// minutes. A vessel is a stranger until its autopilot sends our dialect and DEPTH: other firmware
/// uses DEPTH for an echo sounder.
class Neighbours {
 public:
  /// Our own and our leader's system id. If `least_m` (FS_SEP_M) is 0, no vessel is tracked.
  void configure(std::uint8_t own_system, std::uint8_t leader_system, float least_m);

  bool watches() const { return watches_; }

  /// Origin of the frame in which places are kept; not valid before the first one.
  const link::GpsGlobalOrigin& frame() const { return frame_; }

  /// Takes any message. Keeps places in the local frame of `own`. `reach_m`: half of the length by
  /// which the sender's hull is longer than ours; nullopt: unknown. S: scalar of the computation.
  template <class S = double>
  void take(const link::Received& received, const convert::Position& own, std::int64_t now_us,
            std::optional<float> reach_m = std::nullopt) {
    if (own.origin.latitude != frame_.latitude || own.origin.longitude != frame_.longitude) {
      look_from<S>(own);
    }
    if (may_tell(received)) take_news<S>(received, own, now_us, reach_m);
  }

  /// At least one other vessel is known.
  bool any(std::int64_t now_us) const;

  /// The known vessels, extrapolated to now, relative to `own` + `moved_n`.
  template <class S>
  core::Traffic<S> traffic(const convert::Position& own, const core::Vec2<S>& moved_n,
                           std::int64_t now_us) const;

  /// No vessel is within FS_SEP_M, and no late state of the last 3 s puts one there: such a state
  /// may come from a second vessel with that id.
  template <class S>
  bool clear(const convert::Position& own, const core::Vec2<S>& moved_n, std::int64_t now_us) const;

  /// System id of a vessel whose messages, some or all, arrive more than three seconds late.
  std::optional<std::uint8_t> late(std::int64_t now_us) const {
    return now_us - late_us_ < kForgotten_us ? std::optional(late_) : std::nullopt;
  }

  /// Our depth in the tree: our leader's plus 1; 1 if our leader is virtual or sends no depth.
  std::uint8_t depth() const;

 private:
  static constexpr std::int64_t kForgotten_us = 3'000'000;
  /// Vessels in memory; traffic() contains the nearest of them. If a resting ship is dropped, its
  /// next report may come only three minutes later.
  static constexpr std::size_t kKept =
      FLOTILLA_LOOKS_AHEAD != 0 ? 4 * core::kMaxVessels : core::kMaxVessels;
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min() / 2;
  struct Vessel {
    std::uint32_t id = 0;  ///< system id, or MMSI (always greater); 0: a free entry
    bool located = false;
    bool dated = false;    ///< ahead_us is known
    bool rests = false;    ///< a ship that stays where it is
    bool steered = false;  ///< drives itself; only then can it yield
    std::optional<std::uint8_t> depth;
    std::uint16_t late_ms = 0;  ///< age of its state when the vessel was last heard
    float v_north_mps = 0, v_east_mps = 0;
    float reach_m = 0;  ///< how far a ship's hull extends from its position, a member's beyond ours
    Metres north_m, east_m;
    std::int64_t true_us = 0;   ///< when its state was true, by our clock
    std::int64_t ahead_us = 0;  ///< our clock minus its stamps, from its fastest message
  };

  /// Origin of a system's local frame; also kept for vessels without an entry: they may come
  /// nearer.
  struct LocalFrame {
    std::int32_t latitude = 0, longitude = 0;  ///< as in GPS_GLOBAL_ORIGIN
    std::int16_t altitude_m = 0;
    std::uint8_t system = 0;  ///< 0: free
  };

  /// Whether a message can be useful; false for states of our own unit and of a virtual leader.
  bool may_tell(const link::Received& received) const {
    const auto [system, component] = received.from;
    if (!link::tells_motion(received.message)) return true;
    return system != own_system_ && autopilot_[system] == component;
  }
  template <class S>
  void take_news(const link::Received& received, const convert::Position& own, std::int64_t now_us,
                 std::optional<float> reach_m);
  void take_heartbeat(link::Address from, const link::Heartbeat& message, std::int64_t now_us);
  void take_depth(link::Address from, const link::NamedValueFloat& message);
  void take_origin(std::uint8_t system, const link::GpsGlobalOrigin& message);
  std::optional<link::GpsGlobalOrigin> origin_of(std::uint32_t id) const;
  template <class S>
  void take_ais(const link::AisVessel& message, const convert::Position& own, std::int64_t now_us);
  /// Stores the place if this is the vessel's newest state, and returns its entry; else nullptr.
  template <class S>
  Vessel* take_place(std::uint32_t id, const convert::Sample<S>& sample,
                     std::optional<float> reach_m, const convert::Position& own,
                     std::int64_t now_us);
  bool date(Vessel& vessel, std::int64_t stamp_us, std::int64_t now_us);
  bool date_by_stamp(Vessel& vessel, std::int64_t stamp_us, std::int64_t now_us);
  template <class S>
  void look_from(const convert::Position& own);
  Vessel* find(std::uint32_t id);
  Vessel* find_at(std::uint32_t id, const convert::Position& place, std::int64_t stamp_us,
                  std::int64_t now_us);
  /// How near a vessel comes to us, m.
  static double comes_m(const Vessel& vessel, const convert::Position& own);
  Vessel* place_for(std::uint32_t id, double near_m, const convert::Position& own,
                    std::int64_t now_us);
  static std::int64_t patience_us(const Vessel& vessel);
  static bool counts(const Vessel& vessel, std::int64_t now_us);
  bool has_way(const Vessel& vessel) const;
  std::span<const Vessel> tracked() const { return std::span(vessels_).first(used_); }
  template <class S>
  static core::OtherVessel<S> seen(const Vessel& vessel, const convert::Position& own,
                                   const core::Vec2<S>& moved_n, std::int64_t now_us);

  std::uint8_t own_system_ = 0, leader_system_ = 0;
  float least_m_ = 0;
  bool watches_ = false;
  std::optional<std::uint8_t> leader_depth_;
  link::GpsGlobalOrigin frame_{};  // of all places
  std::int64_t late_us_ = kNever;  // when a message was last late
  std::int64_t late_near_us_ = kNever;
  std::uint8_t late_ = 0;  // whose it is
  std::array<Vessel, kKept> vessels_{};
  std::array<LocalFrame, 2 * kKept> local_frames_{};
  std::size_t last_frame_ = 0;                 // entered last
  std::size_t used_ = 0;                       // entries of vessels_ that were ever in use
  std::array<std::uint8_t, 256> autopilot_{};  // component, by system; 0: none was heard
  std::bitset<256> idle_;                      // which of them tell no place
  std::array<std::uint8_t, 256> speaker_{};    // component that speaks our dialect, by system
};

}  // namespace flotilla::app
