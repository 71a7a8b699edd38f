// SPDX-License-Identifier: MIT
// The formation's reference: the motion of the vessel that the whole tree follows, as it is heard
// from any boat of the branch, judged, and handed on.
#pragma once

#include <cstdint>
#include <optional>

#include "app/guidance/tree_place.hpp"
#include "app/navigation/sender_clocks.hpp"
#include "app/navigation/vessel_track.hpp"
#include "core/reference.hpp"

namespace flotilla::app {

/// A boat whose leader sails in its slot of a reference takes the newest of that branch, whoever
/// tells it. One whose leader tells none, a virtual leader, an autopilot, a tablet, makes the
/// reference of its own track of it. What fails a test is counted, not followed, not handed on.
template <class S>
class Reference {
 public:
  /// Parameters, and the own system id, as they are from now on.
  void configure(const Parameters& p, std::uint8_t own_system);

  /// Any message; own: where we are, nullptr where that is unknown.
  void take(const link::Received& received, const convert::Position* own, std::int64_t now_us,
            link::Counters& counters);

  /// A vessel answered the TIMESYNC request that we sent at `sent_us`.
  void answered(link::Address from, std::int64_t sent_us, std::int64_t read_us,
                std::int64_t now_us) {
    clocks_.answered(from, sent_us, read_us, now_us);
  }

  /// To be called in every tick: makes the reference where that is ours to do. Switched off it does
  /// so too, that it may be switched on at any time.
  void make(VesselTrack<S>& leader, std::int64_t now_us);

  /// The root now, in place of the leader.
  struct Aim {
    Branch branch;
    convert::Position position;  ///< when it was true
    core::Motion<S> motion;      ///< since
    RootOffset offset;           ///< our slot
    RootOffset leaders_offset;
  };
  /// Nothing where there is none that can be followed.
  std::optional<Aim> aim(std::int64_t now_us) const;

  /// The message for others; nothing while there is nothing that they can trust. It is another one
  /// whenever news() is another number.
  std::optional<link::FormationReference> message(std::int64_t now_us, bool followed) const;
  std::uint32_t news() const { return news_; }

  const TreePlace& place() const { return place_; }
  std::optional<std::int64_t> age_us(std::int64_t now_us) const;

 private:
  struct Held {
    Branch branch;
    std::uint16_t sequence = 0;
    link::ReferenceMotion told;
    convert::RootState<S> root;
    std::int64_t valid_us = 0;
    bool near = false;
  };

  bool is_newer(const link::FormationReference& message, const Branch& branch,
                std::int64_t valid_us) const;
  bool is_believed(const convert::RootState<S>& root, std::int64_t valid_us, std::int64_t now_us);
  const Held* held(std::int64_t now_us, std::int64_t oldest_us) const;
  void hold(const Held& held);

  bool on_ = false;
  core::ForesightLimits<S> limits_;
  TreePlace place_;
  SenderClocks clocks_;
  JumpGuard<S> guard_;
  std::optional<Held> held_;
  std::uint32_t news_ = 0;
  core::TrackState<S> shaped_;  // the leader's motion, as others are told of it
  std::uint16_t made_ = 0;
};

}  // namespace flotilla::app
