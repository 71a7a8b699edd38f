// SPDX-License-Identifier: MIT
// All parameters that an operator may set, each with unit, default, range and description.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace flotilla::app {

/// ArduPilot Rover's mode numbers: clients translate them to names by vehicle type.
namespace mode {
constexpr std::uint8_t kManual = 0, kHold = 4, kLoiter = 5, kFormation = 6, kAuto = 10,
                       kReturn = 11, kGuided = 15;
}

struct Parameters {
#define FLOTILLA_PARAMETER(group, name, unit, value, least, greatest, kind, change, sentence) \
  float name = static_cast<float>(value);
#include "app/parameters.def"
#undef FLOTILLA_PARAMETER
};

enum class ParameterKind : std::uint8_t {
  kReal,
  kWhole,
  kSign,
  kIdentity,
  kAutopilot,
  kFrame,
  kSwitch,
  kAction,
  kStop
};
enum class ParameterChange : std::uint8_t { kAnytime, kDisarmed, kRestart };

struct ParameterInfo {
  std::string_view name;
  std::string_view unit;
  float least;
  float greatest;
  ParameterKind kind;
  ParameterChange change;
  float Parameters::* member;

  float default_value() const { return Parameters{}.*member; }
  bool whole() const { return kind != ParameterKind::kReal; }
};

inline constexpr std::array kParameterList{
#define FLOTILLA_PARAMETER(group, name, unit, value, least, greatest, kind, change, sentence) \
  ParameterInfo{#name,                                                                        \
                unit,                                                                         \
                static_cast<float>(least),                                                    \
                static_cast<float>(greatest),                                                 \
                ParameterKind::k##kind,                                                       \
                ParameterChange::k##change,                                                   \
                &Parameters::name},
#include "app/parameters.def"
#undef FLOTILLA_PARAMETER
};

/// Texts of the parameter at the same place in kParameterList. Programs that do not use them do not
/// contain them.
struct ParameterText {
  std::string_view group;
  std::string_view sentence;
};

inline constexpr std::array kParameterTexts{
#define FLOTILLA_PARAMETER(group, name, unit, value, least, greatest, kind, change, sentence) \
  ParameterText{group, sentence},
#include "app/parameters.def"
#undef FLOTILLA_PARAMETER
};

/// The entry with that name, or nullptr.
const ParameterInfo* find_parameter(std::string_view name);

/// Whether the value is finite, in range, and of the kind required: whole or ±1.
bool is_valid(const ParameterInfo& info, float value);

/// Distance to keep from other vessels, m: FS_SEP_M; if negative, derived from the boat's length.
constexpr float separation_m(const Parameters& p) {
  constexpr float kLengths = 1.2F;  // does not disturb slots two lengths apart
  return p.FS_SEP_M < 0 ? kLengths * p.BOAT_LEN : p.FS_SEP_M;
}

/// Describes the first contradiction between parameters that are each valid; nothing if none.
std::optional<std::string_view> contradiction(const Parameters& parameters);

}  // namespace flotilla::app
