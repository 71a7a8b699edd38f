// SPDX-License-Identifier: MIT
// The control loop's latencies and the counters of links and bus, written to a JSON file at exit.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "link/counters.hpp"
#include "linux/can/can_bus.hpp"
#include "linux/latency.hpp"

namespace flotilla::target {

struct Statistics {
  Latency lateness;            ///< of the wake-up
  Latency processing;          ///< from the tick's start until the command is sent
  Latency response;            ///< from the first bytes received until the command is sent
  std::uint32_t overruns = 0;  ///< ticks more than a period late
};

/// Returns an error as a sentence.
std::optional<std::string> write_statistics(const std::filesystem::path& path,
                                            const Statistics& loop, const link::Counters& mavlink,
                                            const CanBusCounters& can);

}  // namespace flotilla::target
