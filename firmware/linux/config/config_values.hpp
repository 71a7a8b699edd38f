// SPDX-License-Identifier: MIT
// Parses the configuration's values, from the file or the command line.
#pragma once

#include <charconv>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "linux/config/config.hpp"

namespace flotilla::target {

/// Names a value that is not allowed, and the allowed ones. Whoever catches this adds the file and
/// key, or the option.
struct ValueError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The complete error as one line for the operator.
struct ConfigError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The whole text as a number, or nothing.
template <class T>
std::optional<T> number(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Each throws ValueError.
std::string can_address(std::string_view text);
MavlinkLinkConfig mavlink_link(std::string_view text);  ///< ADDRESS[,rate=BYTES][,signing=POLICY]
void require_link_count(std::size_t count);
/// `text`: the value as written; value: nothing if it is not a number.
float parameter_value(std::string_view name, std::optional<double> value, std::string_view text);
StopLine stop_line(std::string_view text);  ///< CHIP:LINE, "": none
int priority_value(std::optional<std::int64_t> value);

/// Reads a ground station's parameter file into `param`: NAME,VALUE lines as Mission Planner and
/// MAVProxy write them, or QGroundControl's five columns. Throws ConfigError.
void read_parameter_list(const std::string& file, ParameterOverrides& param);

/// Reads boat.toml. Throws ConfigError.
Config read_config_file(const std::string& file);

}  // namespace flotilla::target
