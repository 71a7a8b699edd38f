// SPDX-License-Identifier: MIT
// Replays a recorded stream to one boat and digests its output.
//
// The stream has records as in sil/lockstep/recording.py, of one boat, in its own clock: time (u64 µs), port
// (u16), length (u16), bytes. Ports: n: MAVLink of link n; 8: CAN, identifier (u32) and data; 32:
// state of the bus, up (u8); 33: a control tick. The first record has port 34: number of links
// (u32), and every parameter (float) in the order of their table.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "app/boat/boat.hpp"
#include "app/boat/law_scalar.hpp"
#include "cortex_m/sha256.hpp"

namespace flotilla::target {

/// Longest chunk that a link delivers at once.
constexpr std::size_t kMaxBytes = 1500;

struct Record {
  std::uint64_t t_us = 0;
  std::uint16_t port = 0;
  std::uint16_t length = 0;
};

class Player {
 public:
  /// Passes a record to the boat. False before a boat exists, or for an unknown port.
  bool play(const Record& record, std::span<const std::uint8_t> bytes);

  /// Whether the last record was a control tick.
  bool ticked() const { return out_.has_value(); }

  /// After a tick: adds the boat's output to the digest, as records of ports 16 + n and 24.
  void digest();

  std::array<std::uint8_t, 32> finish() { return sha256_.finish(); }

  bool drives() const { return boat_ != nullptr && boat_->state() == core::State::kFormation; }

 private:
  bool build(std::span<const std::uint8_t> bytes);
  void add(std::uint16_t port, std::span<const std::uint8_t> head,
           std::span<const std::uint8_t> bytes);

  /// As on a microcontroller: one radio, one serial line.
  static constexpr std::size_t kLinks = 2, kSigningStreams = 16, kPlanItems = 100, kFenceItems = 30,
                               kRallyPoints = 5;
  app::Room<kLinks, kSigningStreams, kPlanItems, kFenceItems, kRallyPoints> room_;
  app::Outbox<kLinks> outbox_;
  /// Never destroyed: that would need a heap.
  alignas(app::Boat<Scalar>) std::array<std::byte, sizeof(app::Boat<Scalar>)> place_;
  app::Boat<Scalar>* boat_ = nullptr;
  std::size_t links_ = 0;
  std::optional<app::Boat<Scalar>::Output> out_;
  std::uint64_t t_us_ = 0;
  Sha256 sha256_;
};

}  // namespace flotilla::target
