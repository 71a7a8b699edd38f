// SPDX-License-Identifier: MIT
#include "fleet/vessel_faults.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "link/dronecan/messages.hpp"

namespace flotilla::fleet {
namespace {

using enum FaultKind;

constexpr double kDegE7PerMetre = 89.93;  // northwards, on a sphere of 6371 km
// The impostor's stamps lie between the vessel's, so each of its messages is newer.
constexpr std::int64_t kImpostorAhead_us = 5'000;

void move_north(std::array<double, 3>& eta, std::array<std::int32_t, 2>& degE7, double by_m) {
  eta[0] += by_m;
  degE7[0] += static_cast<std::int32_t>(std::lround(kDegE7PerMetre * by_m));
}

}  // namespace

std::array<SplitMix64, kFaultKinds> VesselFaults::make_random() {
  return []<std::size_t... kind>(std::index_sequence<kind...>) {
    return std::array{SplitMix64(kind)...};
  }(std::make_index_sequence<kFaultKinds>());
}

void VesselFaults::set(const Fault& fault) {
  const auto kind = static_cast<std::size_t>(fault.kind);
  active_.set(kind);
  value_[kind] = fault.value;
  random_[kind] = SplitMix64(fault.seed);
}

void VesselFaults::clear(FaultKind kind) {
  active_.reset(static_cast<std::size_t>(kind));
  if (kind == kOwnFrozen) frozen_.reset();
  if (kind == kImpostor) impostor_.reset();
  if (kind == kOwnImpostor) own_impostor_.reset();
  if (kind == kReplay) to_repeat_.clear();
}

Sensed VesselFaults::measured(const Sensed& truth) {
  std::copy_n(truth.eta, 3, truth_.eta.begin());
  std::copy_n(truth.nu, 3, truth_.nu.begin());
  truth_.degE7 = truth.degE7;
  told_ = truth_;
  if (has(kOwnFrozen)) {
    if (!frozen_) frozen_ = truth_;
    told_ = *frozen_;
  }
  if (has(kOwnJump)) move_north(told_.eta, told_.degE7, value(kOwnJump));
  return told_.sensed();
}

void VesselFaults::send_beside(std::int64_t now_us, Bytes& out) {
  if (!own_impostor_) return;
  Pose pose = truth_;
  move_north(pose.eta, pose.degE7, value(kOwnImpostor));
  own_impostor_->tick(now_us + kImpostorAhead_us, pose.sensed(), out);
}

void VesselFaults::put_on_bus(std::int64_t now_us, std::vector<link::CanFrame>& out) {
  if (!has(kStopSwitch) || !button_rate_.due(now_us)) return;
  constexpr std::uint8_t kNode = 50, kPriority = 24, kPressTime = 10;
  constexpr link::DataType type = link::Button::kType;
  constexpr std::array payload{link::Button::kSafety, kPressTime};
  // Fits into one frame.
  static_cast<void>(split_transfer({kPriority, type.kind, type.id, kNode, 0}, type,
                                   button_id_++ & 0x1FU, payload,
                                   std::span(&out.emplace_back(), 1)));
}

std::int64_t VesselFaults::unit_ahead_us() const {
  return has(kOwnClock) ? std::llround(1e6 * value(kOwnClock)) : 0;
}

bool VesselFaults::strikes(FaultKind kind) {
  return has(kind) && random_[static_cast<std::size_t>(kind)].uniform() < value(kind);
}

bool VesselFaults::passes_bus() { return !has(kBusOff) && !strikes(kFrameLoss); }

bool VesselFaults::passes_radio() { return !has(kRadioSilent) && !strikes(kRadioLoss); }

void VesselFaults::damage(std::span<std::uint8_t> bytes) {
  SplitMix64& random = random_[static_cast<std::size_t>(kByteErrors)];
  for (std::uint8_t& byte : bytes) {
    if (strikes(kByteErrors)) {
      byte = static_cast<std::uint8_t>(byte ^ (1 + static_cast<unsigned>(255 * random.uniform())));
    }
  }
}

std::span<const std::uint8_t> VesselFaults::aired(std::span<const std::uint8_t> sent,
                                                  std::int64_t t_us, std::int64_t now_us) {
  aired_.clear();
  if (!sent.empty() && passes_radio()) {
    aired_.assign(sent.begin(), sent.end());
    damage(aired_);
  }
  if (impostor_) {
    Pose pose = truth_;
    move_north(pose.eta, pose.degE7, value(kImpostor));
    impostor_->tick(now_us + kImpostorAhead_us, pose.sensed(), aired_);
  }
  if (has(kReplay)) send_again(sent, t_us);
  return aired_;
}

void VesselFaults::send_again(std::span<const std::uint8_t> sent, std::int64_t t_us) {
  if (!sent.empty()) to_repeat_.push_back({t_us, Bytes(sent.begin(), sent.end())});
  const std::int64_t until_us = t_us - std::llround(1e6 * value(kReplay));
  for (; !to_repeat_.empty() && to_repeat_.front().t_us <= until_us; to_repeat_.pop_front()) {
    const Bytes& data = to_repeat_.front().data;
    aired_.insert(aired_.end(), data.begin(), data.end());
  }
}

std::span<const std::uint8_t> VesselFaults::heard(std::span<const std::uint8_t> chunk) {
  if (!passes_radio()) return {};
  if (!has(kByteErrors)) return chunk;
  heard_.assign(chunk.begin(), chunk.end());
  damage(heard_);
  return heard_;
}

}  // namespace flotilla::fleet
