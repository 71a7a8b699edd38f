// SPDX-License-Identifier: MIT
// The formation's reference: the motion of the tree's root, received from any boat of the branch,
// checked, and relayed.
#pragma once

#include <cstdint>
#include <optional>

#include "app/guidance/tree_place.hpp"
#include "app/navigation/sender_clocks.hpp"
#include "app/navigation/vessel_track.hpp"
#include "app/parameters/configuration.hpp"
#include "core/future.hpp"

namespace flotilla::app {

/// A boat whose leader follows a reference takes the newest one of that branch from any sender. If
/// the leader sends none (a virtual leader, an autopilot, a tablet), the boat makes the reference
/// from its own track of it. An implausible reference is counted, not followed and not relayed.
template <class S>
class Reference {
 public:
  /// Applies changed parameters and the boat's system id.
  void configure(const Configuration::Formation& formation, const core::ForesightLimits<S>& limits,
                 std::uint8_t own_system);

  /// Takes any message; own: our position, nullptr if unknown.
  void take(const link::Received& received, const convert::Position* own, std::int64_t now_us,
            link::Counters& counters) {
    const auto* told = std::get_if<link::FormationReference>(&received.message);
    if (told != nullptr) take(received.from, *told, own, now_us, counters);
    const auto* future = std::get_if<link::FormationFuture>(&received.message);
    if (future != nullptr) take(received.from, *future, now_us, counters);
  }

  /// A vessel answered the TIMESYNC request that we sent at `sent_us`.
  void answered(link::Address from, std::int64_t sent_us, std::int64_t read_us,
                std::int64_t now_us) {
    clocks_.answered(from, sent_us, read_us, now_us);
  }

  /// Sets whether the boat leads. A boat that leads is the root, whatever its FORM_LEADER and slot
  /// are.
  void lead(bool on);

  /// Takes the motion of the vessel that a leading boat follows in AUTO, as the reference.
  void tell(const convert::RootState<S>& root, std::int64_t now_us);

  /// Takes the same vessel's future motion, from `begun_us` on.
  void tell(const core::Future<S>& future, std::int64_t begun_us);

  /// Makes the reference if this boat is its maker. Call in every tick, also while LAW_REF is 0, so
  /// that it can be switched on at any time.
  void make(VesselTrack<S>& leader, std::int64_t now_us);

  /// The root's present state, to be followed in place of the leader.
  struct Aim {
    Branch branch;
    convert::Position position;  ///< at the time of the reference
    core::Motion<S> motion;      ///< since then
    RootOffset offset;           ///< our slot
  };
  /// nullopt if there is no reference that can be followed.
  std::optional<Aim> aim(std::int64_t now_us) const;

  /// The message for followers; nullopt without a valid reference. news() counts its changes.
  std::optional<link::FormationReference> message(std::int64_t now_us, bool followed) const;
  std::uint32_t news() const { return news_; }

  /// The same for the root's future; nullopt if it is not valid.
  std::optional<link::FormationFuture> future_message(std::int64_t now_us) const;
  std::uint32_t future_news() const { return future_news_; }

  const TreePlace& place() const { return place_; }

  /// A jump of the root was accepted since accept_place().
  bool jumped() const { return guard_.moved(); }
  void accept_place() { guard_.accept(); }

  std::optional<std::int64_t> age_us(std::int64_t now_us) const;

 private:
  void take(link::Address from, const link::FormationReference& message,
            const convert::Position* own, std::int64_t now_us, link::Counters& counters);
  void take(link::Address from, const link::FormationFuture& message, std::int64_t now_us,
            link::Counters& counters);

  struct Held {
    Branch branch;
    std::uint16_t sequence = 0;
    link::FormationReference told;  ///< the motion as a message
    convert::RootState<S> root;
    std::int64_t valid_us = 0;
    bool near = false;
    bool timed = false;  ///< valid_us is known, through all hops
  };
  struct HeldFuture {
    Branch branch;
    link::FormationFuture told;
    core::Future<S> future;
    std::int64_t begun_us = 0;
    bool timed = false;
  };

  bool is_newer(const link::FormationReference& message, const Branch& branch,
                std::int64_t valid_us) const;
  bool believe(const convert::RootState<S>& root, std::int64_t valid_us, std::int64_t now_us);
  bool is_near(const convert::Position& own, const convert::RootState<S>& root,
               std::int64_t now_us) const;
  const Held* held(std::int64_t now_us, std::int64_t oldest_us) const;
  void hold(const auto&... held);
  void settle();
  void shape(const VesselTrack<S>& leader, const core::TrackMessage<S>& message);
  void walk(std::int64_t now_us);
  const HeldFuture* future(std::int64_t now_us) const;
  std::int64_t lasting_us(std::int64_t now_us, std::int64_t plain_us) const;
  Branch mine() const {
    return {leads_ ? place_.own().system : place_.own().leader, place_.own().system};
  }

  TreePlace::Own own_;  // in FORMATION
  bool leads_ = false;
  bool on_ = false;
  convert::Reach reach_{0};
  core::ForesightLimits<S> limits_;
  TreePlace place_;
  SenderClocks clocks_;
  JumpGuard<S> guard_;
  std::optional<Held> held_;
  std::optional<HeldFuture> future_;
  core::FutureWalk<S> walk_;  // from held_ along future_
  bool walks_ = false;
  std::uint32_t news_ = 0, future_news_ = 0;
  core::TrackState<S> shaped_;  // the leader's motion, filtered for followers
  bool shapes_ = false;         // shaped_ is in use: this boat makes the reference
  std::uint16_t made_ = 0;
};

}  // namespace flotilla::app
