// SPDX-License-Identifier: MIT
// A recording of a run's wires, in the layout of sil/lockstep/recording.py.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace flotilla::fleet {

/// An agent's wire and direction; the link's number is added to MAVLink's.
enum class Wire : std::uint8_t {
  kMavlinkIn = 0,
  kCanIn = 8,
  kMavlinkOut = 16,
  kCanOut = 24,
  kHost = 32
};

/// Events of a boat's host.
enum class HostEvent : std::uint8_t {
  kBus,      ///< the CAN interface is up (1) or down (0)
  kClock,    ///< new offset of the boat's clock from the world's, µs
  kRestart,  ///< a new process
};

class Records {
 public:
  static constexpr std::size_t kMaxAgents = 256;

  /// Appends a record: a chunk, or a CAN frame by its identifier and data.
  void chunk(std::int64_t t_us, std::size_t agent, Wire wire, std::size_t link,
             std::span<const std::uint8_t> data) {
    head(t_us, agent, static_cast<std::size_t>(wire) + link, data.size());
    put(data);
  }
  void frame(std::int64_t t_us, std::size_t agent, Wire wire, std::uint32_t id,
             std::span<const std::uint8_t> data) {
    head(t_us, agent, static_cast<std::size_t>(wire), sizeof id + data.size());
    put(bytes_of(id));
    put(data);
  }

  void host(std::int64_t t_us, std::size_t agent, HostEvent event, std::int64_t value) {
    head(t_us, agent, static_cast<std::size_t>(Wire::kHost), sizeof event + sizeof value);
    put(bytes_of(event));
    put(bytes_of(value));
  }

  /// All records since the last call.
  std::vector<std::uint8_t> take() { return std::exchange(bytes_, {}); }

 private:
  template <class T>
  static std::array<std::uint8_t, sizeof(T)> bytes_of(T value) {
    std::array<std::uint8_t, sizeof(T)> bytes;
    std::memcpy(bytes.data(), &value, sizeof value);
    return bytes;
  }

  void put(std::span<const std::uint8_t> data) {
    bytes_.insert(bytes_.end(), data.begin(), data.end());
  }

  void head(std::int64_t t_us, std::size_t agent, std::size_t channel, std::size_t length) {
    if (length > 0xFFFF) {
      throw std::length_error("a chunk of " + std::to_string(length) + " bytes fits no record");
    }
    put(bytes_of(t_us));
    put(bytes_of(static_cast<std::uint16_t>(agent << 8U | channel)));
    put(bytes_of(static_cast<std::uint16_t>(length)));
  }

  std::vector<std::uint8_t> bytes_;
};

}  // namespace flotilla::fleet
