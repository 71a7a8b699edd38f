// SPDX-License-Identifier: MIT
// Every number an operator may set, with its unit, default, range and sentence.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

namespace flotilla::app {

struct Parameters {
#define FLOTILLA_PARAMETER(name, unit, value, least, greatest, integer, sentence) \
  float name = static_cast<float>(value);
#include "app/parameters.def"
#undef FLOTILLA_PARAMETER
};

struct ParameterInfo {
  std::string_view name;
  std::string_view unit;
  float default_value;
  float least;
  float greatest;
  bool integer;
  std::string_view sentence;
  float Parameters::* member;
};

inline constexpr std::array kParameterList{
#define FLOTILLA_PARAMETER(name, unit, value, least, greatest, integer, sentence) \
  ParameterInfo{#name,                                                            \
                unit,                                                             \
                static_cast<float>(value),                                        \
                static_cast<float>(least),                                        \
                static_cast<float>(greatest),                                     \
                integer,                                                          \
                sentence,                                                         \
                &Parameters::name},
#include "app/parameters.def"
#undef FLOTILLA_PARAMETER
};

/// The entry of that name.
const ParameterInfo* find_parameter(std::string_view name);

/// Whether the value is finite, in range, and whole (and not 0 for a ±1) where it must be.
bool is_valid(const ParameterInfo& info, float value);

/// The first pair of parameters that are each in range but not together, as a sentence.
std::optional<std::string_view> contradiction(const Parameters& parameters);

}  // namespace flotilla::app
