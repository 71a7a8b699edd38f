// SPDX-License-Identifier: MIT
#include "fleet/vessel_faults.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "link/dronecan/messages.hpp"
#include "link/mavlink/mav.hpp"

namespace flotilla::fleet {
namespace {

using enum FaultKind;

constexpr double kDegE7PerMetre = 89.93;  // northwards, on a sphere of 6371 km
// The impostor's stamps lie between the vessel's, so each of its messages is newer.
constexpr std::int64_t kImpostorAhead_us = 5'000;
constexpr std::uint8_t kFirstAnchored = 110;  // system id
constexpr double kLateAhead_m = 8, kCrowdAhead_m = 6, kCrowdApart_m = 5;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

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
  if (kind == kOwnFrozen || kind == kOwnStuck) frozen_.reset();
  if (kind == kImpostor) impostor_.reset();
  if (kind == kOwnImpostor) own_impostor_.reset();
  if (kind == kOwnLateKind) late_kind_.reset();
  if (kind == kReplay) to_repeat_.clear();
  weigh(kind);
}

Sensed VesselFaults::measured(const Sensed& truth) {
  std::copy_n(truth.eta, 3, truth_.eta.begin());
  std::copy_n(truth.nu, 3, truth_.nu.begin());
  truth_.degE7 = truth.degE7;
  told_ = truth_;
  if (has(kOwnFrozen) || has(kOwnStuck)) {
    if (!frozen_) frozen_ = truth_;
    told_ = *frozen_;
    if (!has(kOwnFrozen)) {
      told_.eta[2] = truth_.eta[2];
      told_.nu = {0, 0, truth_.nu[2]};
    }
  }
  if (has(kOwnJump)) move_north(told_.eta, told_.degE7, value(kOwnJump));
  return told_.sensed();
}

void VesselFaults::weigh(FaultKind kind) {
  std::erase_if(anchored_, [=](const Anchored& one) { return one.kind == kind; });
  if (kind != kAisShip) return;
  ship_.reset();
  ship_rate_ = Rate(kShipRate_Hz);
}

void VesselFaults::anchor(const Fault& fault, const std::array<std::int32_t, 3>& origin) {
  weigh(fault.kind);
  origin_ = origin;
  UnitSettings settings{.rate_hz = 5,
                        .message = StateMessage::kLocal,
                        .attitude_rate_hz = 0,
                        .origin = origin,
                        .timesync = false,
                        .vehicle = true};
  const auto add = [&](link::Address self, double ahead_m, double lasts_s) {
    anchored_.push_back({fault.kind, NavigationUnit(self, settings), ahead_m, lasts_s});
  };
  constexpr double kForEver_s = std::numeric_limits<double>::infinity();
  constexpr std::uint8_t kAutopilot = link::mav::kComponentAutopilot;
  if (fault.kind == kAnchored) {
    add({kFirstAnchored, kAutopilot}, fault.value, kForEver_s);
    settings.dropout_every_s = settings.dropout_s = 1;  // no state, only heartbeats
    add({kFirstAnchored, kAutopilot + 1}, fault.value, kForEver_s);
  } else if (fault.kind == kAnchoredLate) {
    add({kFirstAnchored, kAutopilot}, kLateAhead_m, fault.value);
    settings.delay_s = fault.value;
    add({kFirstAnchored, kAutopilot}, kLateAhead_m, kForEver_s);
  } else if (fault.kind == kCrowd) {
    for (auto n = static_cast<int>(std::ceil(fault.value)); n-- > 0;) {  // the nearest comes last
      const auto system = static_cast<std::uint8_t>(kFirstAnchored + n);
      add({system, kAutopilot}, kCrowdAhead_m + kCrowdApart_m * n, kForEver_s);
    }
  }
}

VesselFaults::Pose VesselFaults::ahead(double by_m) const {
  Pose pose = truth_;
  pose.eta[0] += by_m * std::cos(truth_.eta[2]);
  pose.eta[1] += by_m * std::sin(truth_.eta[2]);
  pose.nu = {};
  return pose;
}

std::span<const std::uint8_t> VesselFaults::sent_to(std::uint8_t system, std::int64_t now_us) {
  others_.clear();
  for (Anchored& one : anchored_) {
    if (!one.place) {
      one.place = ahead(one.ahead_m);
      if (one.kind == kAnchored) one.place->nu.fill(kNaN);
      one.since_us = now_us;
    }
    if (static_cast<double>(now_us - one.since_us) > 1e6 * one.lasts_s) continue;
    one.unit.tick(now_us, one.place->sensed(), others_);
  }
  if (has(kAisShip) && ship_rate_.due(now_us)) report_ship();
  if (has(kOverrides) && override_rate_.due(now_us)) override_at_rest(system);
  return others_.empty() ? std::span(others_) : heard(others_);
}

void VesselFaults::report_ship() {
  if (!ship_) ship_ = ahead(value(kAisShip));
  const double parallel = std::cos(1e-7 * std::numbers::pi / 180 * origin_[0]);
  const std::array place{
      origin_[0] + static_cast<std::int32_t>(std::lround(kDegE7PerMetre * ship_->eta[0])),
      origin_[1] +
          static_cast<std::int32_t>(std::lround(kDegE7PerMetre * ship_->eta[1] / parallel))};
  constexpr MessageType kAisVessel{301, 243};
  constexpr std::uint32_t kMmsi = 227'000'000;
  constexpr std::array<std::uint16_t, 7> kNotTold{};  // course … flags
  ais_.write(others_, kAisVessel, kMmsi, place, kNotTold, std::int8_t{0}, link::mav::kAisAnchored);
}

void VesselFaults::override_at_rest(std::uint8_t system) {
  constexpr MessageType kRcChannelsOverride{70, 124};
  std::array<std::uint16_t, 8> pulses_us{1500, 1500, 1500, 1500, 1100, 1100, 1100, 1100};
  ground_station_.write(others_, kRcChannelsOverride, pulses_us, system,
                        link::mav::kComponentAutopilot);
}

void VesselFaults::send_beside(std::int64_t now_us, Bytes& out) {
  if (late_kind_) late_kind_->tick(now_us, truth_.sensed(), out);
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
