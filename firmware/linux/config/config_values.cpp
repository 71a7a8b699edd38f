// SPDX-License-Identifier: MIT
#include "linux/config/config_values.hpp"

#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <stdexcept>

#include "app/operator/mavlink_links.hpp"
#include "linux/can/can_bus.hpp"
#include "linux/mavlink/mavlink_endpoint.hpp"

namespace flotilla::target {
namespace {

constexpr int kHighestPriority = 99;

std::string short_text(float value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

void require_scheme(std::string_view address, std::initializer_list<std::string_view> schemes,
                    std::string_view what) {
  for (const std::string_view scheme : schemes) {
    if (address.starts_with(scheme) && address.size() > scheme.size()) return;
  }
  std::string allowed;
  for (const std::string_view scheme : schemes) {
    allowed += (allowed.empty() ? "" : ", ") + std::string(scheme);
  }
  throw ValueError("\"" + std::string(address) + "\" is not a " + std::string(what) +
                   " (allowed: " + allowed + "…)");
}

/// Four fifths of a serial line's capacity (8N1), because a full line delays all later messages; 0
/// for other links.
std::uint32_t default_rate(std::string_view address) {
  if (!address.starts_with("serial:")) return 0;
  constexpr std::uint32_t kBitsPerByte = 10;
  const auto baud = number<std::uint32_t>(address.substr(address.rfind(':') + 1));
  return baud.value_or(0) / kBitsPerByte * 4 / 5;
}

/// Reads one option of a link, with its leading comma.
void read_link_option(std::string_view option, MavlinkLinkConfig& link) {
  constexpr std::string_view kRate = ",rate=", kSigning = ",signing=";
  if (option.starts_with(kRate)) {
    if (const auto rate = number<std::uint32_t>(option.substr(kRate.size()))) {
      link.bytes_per_s = *rate;
      return;
    }
  } else if (option.starts_with(kSigning)) {
    link.signing = app::signing_policy(option.substr(kSigning.size()));
    if (link.signing) return;
  }
  throw ValueError("\"" + std::string(option) + "\" of " + link.address +
                   " is invalid (allowed: ,rate=BYTES with whole bytes per second, 0: no limit; "
                   ",signing=off, accept or required)");
}

/// Reports a malformed address like any other invalid value, with its place in the file.
void require_address(void (*require)(std::string_view), std::string_view address) {
  try {
    require(address);
  } catch (const std::runtime_error& error) {
    throw ValueError(error.what());
  }
}

}  // namespace

std::string can_address(std::string_view address) {
  require_scheme(address, {"socketcan:", "mcast:"}, "CAN bus");
  require_address(require_can_address, address);
  return std::string(address);
}

MavlinkLinkConfig mavlink_link(std::string_view text) {
  const std::string_view address = text.substr(0, text.find(','));
  require_scheme(address, {"udpin:", "udpout:", "udpbcast:", "serial:"}, "MAVLink link");
  require_address(require_mavlink_address, address);
  MavlinkLinkConfig link{std::string(address), default_rate(address)};
  for (text.remove_prefix(address.size()); !text.empty();) {
    const std::string_view option = text.substr(0, text.find(',', 1));
    read_link_option(option, link);
    text.remove_prefix(option.size());
  }
  return link;
}

void require_link_count(std::size_t count) {
  if (count <= app::kMaxLinks) return;
  throw ValueError(std::to_string(count) + " links (allowed: 1 to " +
                   std::to_string(app::kMaxLinks) + ")");
}

/// A parameter's value; `text`: as written.
float parameter_value(std::string_view name, std::optional<double> value, std::string_view text) {
  const app::ParameterInfo* info = app::find_parameter(name);
  if (info == nullptr) {
    throw ValueError("unknown parameter \"" + std::string(name) +
                     "\" (see firmware/docs/PARAMETERS.md)");
  }
  // A conversion beyond float's range would be undefined.
  const bool fits = value && std::abs(*value) <= double{std::numeric_limits<float>::max()};
  if (fits && app::is_valid(*info, static_cast<float>(*value))) return static_cast<float>(*value);
  const bool is_sign = info->kind == app::ParameterKind::kSign;
  throw ValueError(std::string(name) + " = " + std::string(text) + " (allowed: " +
                   (is_sign ? std::string("-1 or 1")
                            : std::string(info->whole() ? "whole numbers " : "numbers ") + "from " +
                                  short_text(info->least) + " to " + short_text(info->greatest)) +
                   (info->unit.empty() ? "" : " " + std::string(info->unit)) + ")");
}

StopLine stop_line(std::string_view text) {
  if (text.empty()) return {};
  const std::size_t colon = text.find(':');
  const auto line = colon == text.npos ? std::nullopt : number<unsigned>(text.substr(colon + 1));
  const std::string_view chip = text.substr(0, colon);
  if (!line || chip.empty() || chip.find('/') != chip.npos) {
    throw ValueError("\"" + std::string(text) + "\" is not CHIP:LINE, such as gpiochip0:17");
  }
  return {std::string(chip), *line};
}

int priority_value(std::optional<std::int64_t> value) {
  if (value && *value >= 0 && *value <= kHighestPriority) return static_cast<int>(*value);
  throw ValueError("allowed: whole numbers from 0 (off) to " + std::to_string(kHighestPriority));
}

}  // namespace flotilla::target
