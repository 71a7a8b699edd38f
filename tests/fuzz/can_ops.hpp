// SPDX-License-Identifier: MIT
// The fuzzer's input to a boat's CAN bus.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "fuzz/stream.hpp"
#include "link/dronecan/messages.hpp"

namespace flotilla::fuzz {

/// Any identifier, up to 8 bytes.
inline link::CanFrame any_frame(Stream& in) {
  link::CanFrame frame;
  frame.id = in.number<std::uint32_t>();
  const auto data = in.take(in.byte() % 9);
  frame.size = static_cast<std::uint8_t>(data.size());
  std::ranges::copy(data, frame.data.begin());
  return frame;
}

/// Splits a transfer as a node would, and calls push(frame) for each frame.
template <class Push>
void transfer(const link::Route& route, const link::DataType& type, std::uint8_t transfer_id,
              std::span<const std::uint8_t> payload, Push push) {
  std::array<link::CanFrame, 20> frames;
  const std::size_t count = link::split_transfer(route, type, transfer_id, payload, frames);
  for (std::size_t i = 0; i < count; ++i) push(frames[i]);
}

template <class Message, class Push>
void message(std::uint8_t node, std::uint8_t transfer_id, const Message& m, Push push) {
  link::Payload payload;
  const std::size_t size = write_payload(m, payload);
  transfer({16, Message::kType.kind, Message::kType.id, node, 0}, Message::kType, transfer_id,
           std::span(payload).first(size), push);
}

/// A transfer of a type that the boat knows, with the fuzzer's payload. One of its frames may be
/// lost, repeated or damaged.
template <class Push>
void any_transfer(Stream& in, std::uint8_t own_node, Push push) {
  static constexpr std::array kTypes{
      link::EscStatus::kType,    link::NodeStatus::kType,
      link::NodeInfo::kRequest,  link::Allocation::kType,
      link::RawCommand::kType,   link::ArmingStatus::kType,
      link::NodeInfo::kResponse, link::DataType{link::TransferKind::kMessage, 20000, 1}};
  const link::DataType type = in.one_of(kTypes);
  const auto node = static_cast<std::uint8_t>(in.byte() & 0x7FU);
  const std::uint8_t ids = in.byte();  // transfer id, and what happens to a frame
  const std::uint8_t destination = type.kind == link::TransferKind::kMessage ? 0 : own_node;
  const auto payload = in.take(in.byte() % 80);
  unsigned number = 0;
  const unsigned victim = in.byte();
  transfer({16, type.kind, type.id, node, destination}, type, ids & 0x1FU, payload,
           [&](link::CanFrame frame) {
             const bool hit = number++ == victim % 8;
             const unsigned fate = ids >> 5U;
             if (hit && fate == 1) return;
             if (hit && fate == 2) push(frame);
             if (hit && fate == 3) frame.data[victim / 8 % 8] ^= 1U << victim % 8U;
             push(frame);
           });
}

}  // namespace flotilla::fuzz
