// SPDX-License-Identifier: MIT
// The fuzzer's input to a boat's MAVLink links.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <variant>

#include "app/parameters.hpp"
#include "fuzz/stream.hpp"
#include "fuzz/watched_boat.hpp"
#include "link/mavlink/encode.hpp"

namespace flotilla::fuzz {

/// All senders to the boat: each has an address and a sequence number.
template <class S>
class Talkers {
 public:
  explicit Talkers(WatchedBoat<S>& boat, const app::Parameters& p) : boat_(&boat) {
    const auto own = static_cast<std::uint8_t>(p.MAV_SYSID);
    const auto leader = static_cast<std::uint8_t>(p.FORM_LEADER);
    const std::array<link::Address, kCount> addresses{
        {{own, 2},
         {leader, 1},
         {255, 190},
         {own, static_cast<std::uint8_t>(p.MAV_COMPID)},
         {own, 1},
         {77, 1},
         {254, 200},
         {leader, 9}}};
    for (std::size_t i = 0; i < kCount; ++i) encoders_[i] = link::MavlinkEncoder(addresses[i]);
    signing_.start(kKey, kSigningClock, 0);
  }

  enum Who : std::uint8_t { kNavigation, kLeader, kOperator };
  static constexpr std::size_t kCount = 8;

  /// Signed if the link has a key.
  void tell(std::uint8_t who, const link::Message& message, std::int64_t now_us,
            std::size_t link = 0) {
    std::array<std::uint8_t, 300> out;
    const std::size_t size = encoders_[who % kCount].encode(
        message, out, signs_ ? &signing_ : nullptr, static_cast<std::uint8_t>(link));
    boat_->on_mavlink(std::span(out).first(size), now_us, link);
  }
  void sign(bool yes) { signs_ = yes; }

  /// The bytes unchanged or, if `whole`, with the right checksum of the frame that they begin with.
  void bytes(std::span<const std::uint8_t> bytes, bool whole, std::int64_t now_us,
             std::size_t link) {
    std::array<std::uint8_t, 255> out;
    std::copy(bytes.begin(), bytes.end(), out.begin());
    const auto all = std::span(out).first(bytes.size());
    if (whole) repair(all, signing_, static_cast<std::uint8_t>(link));
    boat_->on_mavlink(all, now_us, link);
  }

 private:
  WatchedBoat<S>* boat_;
  std::array<link::MavlinkEncoder, kCount> encoders_;
  link::Signing signing_;
  bool signs_ = false;
};

/// Any message, its fields in order from the fuzzer.
link::Message any_message(Stream& in);

/// A parameter's value: at its ends, beyond them, its default, any float.
inline float parameter_value(Stream& in, const app::ParameterInfo& info) {
  const std::uint8_t choice = in.byte();
  switch (choice % 8) {
    case 0:
      return info.least;
    case 1:
      return info.greatest;
    case 2:
      return info.default_value();
    case 3:
      return std::nextafter(info.greatest, std::numeric_limits<float>::infinity());
    case 4:  // whole, between the ends
      return std::round(info.least + (info.greatest - info.least) * float(choice) / 255.0F);
    case 5:
      return info.least + (info.greatest - info.least) * float(in.byte()) / 255.0F;
    case 6:
      return float(in.byte());
    default:
      return in.number<float>();
  }
}

inline link::ParamSet any_parameter(Stream& in, link::Address target) {
  const app::ParameterInfo& info = app::kParameterList[in.byte() % app::kParameterList.size()];
  link::ParamSet set{parameter_value(in, info), target, {}, link::mav::kParamReal32};
  std::ranges::copy(info.name, set.param_id.begin());
  return set;
}

}  // namespace flotilla::fuzz
