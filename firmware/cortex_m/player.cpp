// SPDX-License-Identifier: MIT
#include "cortex_m/player.hpp"

#include <cstring>
#include <new>

namespace flotilla::target {
namespace {

enum Port : std::uint16_t {
  kMavlink = 0,
  kCan = 8,
  kMavlinkOut = 16,
  kCanOut = 24,
  kBus = 32,
  kTick = 33,
  kBoat = 34,
};

std::array<std::uint8_t, 4> bytes_of(std::uint32_t number) {
  std::array<std::uint8_t, 4> bytes;
  std::memcpy(bytes.data(), &number, sizeof number);
  return bytes;
}

template <class T>
T read(std::span<const std::uint8_t> bytes) {
  T value;
  std::memcpy(&value, bytes.data(), sizeof value);
  return value;
}

}  // namespace

bool Player::build(std::span<const std::uint8_t> bytes) {
  app::Parameters p;
  if (bytes.size() != (1 + app::kParameterList.size()) * sizeof(float)) return false;
  const auto links = read<std::uint32_t>(bytes);
  if (links < 1 || links > kLinks) return false;
  for (const app::ParameterInfo& info : app::kParameterList) {
    bytes = bytes.subspan(sizeof(float));
    p.*(info.member) = read<float>(bytes);
  }
  boat_ = new (place_.data()) app::Boat<Scalar>(p, links, {room_, outbox_});
  links_ = links;
  return true;
}

bool Player::play(const Record& record, std::span<const std::uint8_t> bytes) {
  out_.reset();
  if (record.port == kBoat) return build(bytes);
  if (boat_ == nullptr) return false;
  t_us_ = record.t_us;
  const auto now_us = static_cast<std::int64_t>(record.t_us);
  switch (record.port) {
    case kCan:
      if (bytes.size() < 4) return false;
      boat_->on_can(read<std::uint32_t>(bytes), bytes.subspan(4), now_us);
      return true;
    case kBus:
      boat_->on_host({.bus_up = !bytes.empty() && bytes[0] != 0});
      return true;
    case kTick:
      out_ = boat_->tick(now_us);
      return true;
    default:
      if (record.port >= links_) return false;
      boat_->on_mavlink(bytes, now_us, record.port);
      return true;
  }
}

void Player::add(std::uint16_t port, std::span<const std::uint8_t> head,
                 std::span<const std::uint8_t> bytes) {
  const auto length = static_cast<std::uint32_t>(head.size() + bytes.size());
  sha256_.add(bytes_of(static_cast<std::uint32_t>(t_us_)));
  sha256_.add(bytes_of(static_cast<std::uint32_t>(t_us_ >> 32U)));
  sha256_.add(bytes_of(port | length << 16U));
  sha256_.add(head);
  sha256_.add(bytes);
}

void Player::digest() {
  for (const link::CanFrame& frame : out_->can) add(kCanOut, bytes_of(frame.id), frame.bytes());
  for (std::size_t link = 0; link < out_->links->count(); ++link) {
    const auto sent = out_->links->bytes(link);
    if (!sent.empty()) add(static_cast<std::uint16_t>(kMavlinkOut + link), {}, sent);
  }
}

}  // namespace flotilla::target
