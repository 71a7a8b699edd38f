// SPDX-License-Identifier: MIT
// flotillad's configuration: boat.toml, and the same keys as options, which override the file.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "app/operator/mavlink_links.hpp"
#include "app/parameters.hpp"

namespace flotilla::target {

struct MavlinkLinkConfig {
  std::string address;  ///< in open_mavlink_endpoint()'s format
  std::uint32_t bytes_per_s =
      0;  ///< limit for telemetry; 0: none (serial lines have one by default)
  std::optional<app::SigningPolicy> signing = std::nullopt;  ///< see Config::policy()
  bool operator==(const MavlinkLinkConfig&) const = default;
};

/// A line of a GPIO chip; an empty chip: no switch.
struct StopLine {
  std::string chip;
  unsigned line = 0;
  bool operator==(const StopLine&) const = default;
};

/// Parameters by name, known and valid, that override the saved ones at every start.
using ParameterOverrides = std::map<std::string, float, std::less<>>;

struct Config {
  std::string can = "socketcan:can0";      ///< in open_can_bus()'s format
  std::vector<MavlinkLinkConfig> mavlink;  ///< 1 … app::kMaxLinks
  ParameterOverrides param;
  std::filesystem::path state_dir = "/var/lib/flotilla";
  std::filesystem::path signing_key;  ///< file in read_signing_key()'s format; empty: none
  std::filesystem::path log;          ///< directory; empty: no logs
  std::filesystem::path stats;        ///< file for the loop's latencies and counters; empty: none
  StopLine stop;                      ///< GPIO line of a stop switch
  int priority = 0;                   ///< of SCHED_FIFO, 1 … 99; 0: none
  bool lock_memory = false;

  std::filesystem::path parameter_file() const { return state_dir / "parameters.txt"; }
  std::filesystem::path node_id_file() const { return state_dir / "node_ids.txt"; }
  /// In the order of app::Stored.
  std::array<std::filesystem::path, 3> plan_files() const {
    return {state_dir / "plan.txt", state_dir / "fence.txt", state_dir / "rally.txt"};
  }
  std::filesystem::path signing_time_file() const { return state_dir / "signing_time.txt"; }

  /// The link's own policy; by default, required if there is a key, else off.
  app::SigningPolicy policy(const MavlinkLinkConfig& link) const {
    using enum app::SigningPolicy;
    return link.signing.value_or(signing_key.empty() ? kOff : kRequired);
  }
};

/// The program ends with this exit status (2: a mistake in the configuration) and text, for stdout
/// if the status is 0 (--help, --version), else for stderr.
struct Ending {
  int status = 0;
  std::string text;
};

/// Reads the options and the file that --config names. The text for a mistake is one line: the
/// file, line and key, or the option; and the allowed values. `arguments` begins with the program's
/// name. Running as root (`by_root`) is an error, reported before any file is opened.
std::variant<Config, Ending> read_config(std::span<const char* const> arguments, bool by_root);

void apply(const ParameterOverrides& overrides, app::Parameters& parameters);

}  // namespace flotilla::target
