// SPDX-License-Identifier: MIT
#include "fleet/injection.hpp"

#include <array>

#include "link/mavlink/mav.hpp"

namespace flotilla::fleet {
namespace {

using enum FaultKind;
namespace mav = link::mav;

// FAILURE_UNIT and FAILURE_TYPE of common.xml
constexpr std::uint8_t kGps = 4, kMotor = 101, kMavlinkSignal = 105;
constexpr std::uint8_t kOk = 0, kOff = 1, kStuck = 2, kGarbage = 3, kWrong = 4, kIntermittent = 7;

constexpr double kWrong_m = 20, kGarbageShare = 0.1, kIntermittentShare = 0.5;

struct Known {
  std::uint8_t unit, type;
  Fault fault;
};
constexpr std::array<Known, 9> kKnown{
    {{kGps, kOff, {kOwnSilent}},
     {kGps, kStuck, {kOwnFrozen}},
     {kGps, kWrong, {kOwnJump, kWrong_m}},
     {kMotor, kOff, {kEscReboot}},
     {kMotor, kStuck, {kEscStuck}},
     {kMotor, kWrong, {kEscReversed}},
     {kMavlinkSignal, kOff, {kRadioSilent}},
     {kMavlinkSignal, kGarbage, {kByteErrors, kGarbageShare}},
     {kMavlinkSignal, kIntermittent, {kRadioLoss, kIntermittentShare}}}};

constexpr std::array kOfGps{kOwnSilent, kOwnFrozen, kOwnJump};
constexpr std::array kOfMotor{kEscReboot, kEscStuck, kEscReversed};
constexpr std::array kOfRadio{kRadioSilent, kByteErrors, kRadioLoss};

std::span<const FaultKind> faults_of(std::uint8_t unit) {
  switch (unit) {
    case kGps:
      return kOfGps;
    case kMotor:
      return kOfMotor;
    case kMavlinkSignal:
      return kOfRadio;
    default:
      return {};
  }
}

std::optional<Fault> known(const app::Failure& failure) {
  for (const Known& each : kKnown) {
    if (each.unit == failure.unit && each.type == failure.type) return each.fault;
  }
  return std::nullopt;
}

}  // namespace

std::uint8_t judge(const app::Failure& failure) {
  if (faults_of(failure.unit).empty()) return mav::kUnsupported;
  if (failure.type != kOk && !known(failure)) return mav::kUnsupported;
  const unsigned most = failure.unit == kMotor ? 2 : 1;
  return failure.instance <= most ? mav::kAccepted : mav::kDenied;
}

Injection injection_of(const app::Failure& failure) {
  Injection out{faults_of(failure.unit), std::nullopt, known(failure)};
  if (failure.unit == kMotor && failure.instance > 0) out.esc = failure.instance - 1U;
  if (out.sets) out.sets->esc = out.esc;
  return out;
}

}  // namespace flotilla::fleet
