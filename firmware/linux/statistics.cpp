// SPDX-License-Identifier: MIT
#include "linux/statistics.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

namespace flotilla::target {
namespace {

using Json = nlohmann::ordered_json;

Json summary(const Latency& latency) {
  return {{"p50", latency.percentile_us(0.5)},
          {"p99", latency.percentile_us(0.99)},
          {"p99.9", latency.percentile_us(0.999)},
          {"max", latency.greatest_us()}};
}

}  // namespace

std::optional<std::string> write_statistics(const std::filesystem::path& path,
                                            const Statistics& loop, const link::Counters& mavlink,
                                            const CanBusCounters& can) {
  const Json all = {{"lateness_us", summary(loop.lateness)},
                    {"processing_us", summary(loop.processing)},
                    {"response_us", summary(loop.response)},
                    {"ticks", loop.lateness.count()},
                    {"overruns", loop.overruns},
                    {"mavlink",
                     {{"received", mavlink.mavlink_received},
                      {"bad_checksum", mavlink.mavlink_bad_checksum},
                      {"signed", mavlink.mavlink_signed},
                      {"forged", mavlink.mavlink_forged},
                      {"replayed", mavlink.mavlink_replayed},
                      {"future_stamp", mavlink.mavlink_future_stamp},
                      {"unsigned_refused", mavlink.mavlink_unsigned_refused}}},
                    {"can",
                     {{"sent", can.sent},
                      {"received", can.received},
                      {"transfers_dropped", can.transfers_dropped},
                      {"receive_overflows", can.receive_overflows},
                      {"error_frames", can.error_frames},
                      {"bus_off", can.bus_off},
                      {"reopened", can.reopened},
                      {"bad_packets", can.bad_packets}}}};
  std::ofstream file(path);
  file << all.dump(2) << '\n';
  if (file.flush()) return std::nullopt;
  return "stats " + path.string() + ": " + std::strerror(errno);
}

}  // namespace flotilla::target
