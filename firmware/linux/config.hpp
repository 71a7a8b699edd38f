// SPDX-License-Identifier: MIT
// flotillad's configuration: boat.toml, and the same keys as options. The command line wins.
#pragma once

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
  std::string address;            ///< as open_mavlink_endpoint() takes it
  std::uint32_t bytes_per_s = 0;  ///< what telemetry keeps to; 0: no limit
  std::optional<app::SigningPolicy> signing = std::nullopt;  ///< see Config::policy()
  bool operator==(const MavlinkLinkConfig&) const = default;
};

/// Parameters by name, each known and valid, that win over the saved ones at every start.
using ParameterOverrides = std::map<std::string, float, std::less<>>;

struct Config {
  std::string can = "socketcan:can0";      ///< as open_can_bus() takes it
  std::vector<MavlinkLinkConfig> mavlink;  ///< 1 … app::kMaxLinks
  ParameterOverrides param;
  std::filesystem::path state_dir = "/var/lib/flotilla";
  std::filesystem::path signing_key;  ///< file as read_signing_key() takes it; empty: none
  std::filesystem::path log;          ///< directory; empty: no logs
  std::filesystem::path stats;        ///< file for the loop's latencies and counters; empty: none
  int priority = 0;                   ///< of SCHED_FIFO, 1 … 99; 0: none
  bool lock_memory = false;

  std::filesystem::path parameter_file() const { return state_dir / "parameters.txt"; }
  std::filesystem::path node_id_file() const { return state_dir / "node_ids.txt"; }
  std::filesystem::path signing_time_file() const { return state_dir / "signing_time.txt"; }

  /// What the link says; else signatures are looked at where there is a key.
  app::SigningPolicy policy(const MavlinkLinkConfig& link) const {
    using enum app::SigningPolicy;
    return link.signing.value_or(signing_key.empty() ? kOff : kAccept);
  }
};

/// Instead of sailing: what to print, to stdout where the status is 0 (--help, --version), else to
/// stderr, and the exit status (2: a mistake in the configuration).
struct Ending {
  int status = 0;
  std::string text;
};

/// Reads options and the file that --config names. A mistake is one line that says the file, line
/// and key, or the option, and what is allowed there. `arguments` begins with the program's name.
/// Started `by_root` it is a mistake to sail, found before any file is opened.
std::variant<Config, Ending> read_config(std::span<const char* const> arguments, bool by_root);

void apply(const ParameterOverrides& overrides, app::Parameters& parameters);

}  // namespace flotilla::target
