// SPDX-License-Identifier: MIT
// The boat's logs: every MAVLink packet and CAN frame, both directions, in formats that other
// programs open, written by a separate thread. Packets with a key are left out.
//
//   mavlink0-00001.tlog   telemetry log of link 0, the first `mavlink` of the configuration: u64
//                         microseconds since 1970, big endian, then the packet
//   can-00001.log         candump -L: (1700000000.123456) can0 0704060A#FF7C0200C1
//
// Each link has its own log, because a sender numbers its packets on each link separately: in a
// common log readers would take the jumps between those numbers for lost packets.
//
// The control loop puts records into a ring and never waits; if the ring is full they are dropped
// and counted. Every 100 ms the writer empties the ring into the files. kill -9 loses the records
// since then, a power cut those since the last sync (every 5 s).
#pragma once

#include <pthread.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "link/dronecan/can_frame.hpp"
#include "linux/logs/log_file.hpp"
#include "linux/logs/log_ring.hpp"
#include "linux/logs/packet_splitter.hpp"
#include "linux/system/file_descriptor.hpp"
#include "linux/system/first_error.hpp"

namespace flotilla::target {

struct LogSettings {
  std::filesystem::path directory;
  std::string can_name = "can0";               ///< interface name in the candump log
  std::uint64_t file_bytes = 64ULL << 20U;     ///< of one file
  std::uint64_t total_bytes = 1024ULL << 20U;  ///< of all CAN logs, and of all tlogs, of all runs
  std::size_t links = 1;                       ///< that share the tlogs' total
  std::size_t ring_bytes = 1U << 20U;          ///< about 10 s of a busy boat
};

struct LogCounters {
  std::uint64_t written = 0;  ///< records handed to the operating system
  std::uint64_t dropped = 0;  ///< records dropped because the ring was full
  std::uint64_t lost = 0;     ///< records that could not be written to the disk
};

enum class Direction : std::uint8_t { kReceived, kSent };

/// Call mavlink(), can(), counters() and error() from one thread; they never block, throw or
/// allocate. The destructor writes the remaining records and waits for the disk: send the zero
/// commands first. Without a directory it writes and counts nothing.
class Logs {
 public:
  /// Throws std::system_error if the thread cannot be started. A directory that cannot be written
  /// is no error: see error(). The writer receives no signals, has no real-time priority, and a
  /// stack small enough to be locked in memory.
  explicit Logs(LogSettings settings);
  ~Logs();
  Logs(const Logs&) = delete;
  Logs& operator=(const Logs&) = delete;

  /// Bytes received or sent, in any chunks, on link 0 … 63 (of LogSettings::links).
  void mavlink(std::size_t link, Direction direction, std::span<const std::uint8_t> bytes,
               std::int64_t unix_us);
  void can(const link::CanFrame& frame, std::int64_t unix_us);

  LogCounters counters() const;

  /// The first error with the files, once. The writer retries every second.
  std::optional<std::string> error() { return error_.take(); }

 private:
  static constexpr std::size_t kLinks = 64;

  static void* run(void* self);
  void write_until_stopped();
  void drain();
  void write_mavlink(const LogRecord& record, std::span<const std::uint8_t> bytes);
  void write_can(const LogRecord& record, std::span<const std::uint8_t> payload);
  template <class F>
  void each_file(F&& f);
  void publish();
  void put(std::uint8_t channel, std::span<const std::uint8_t> payload, std::int64_t unix_us);

  LogSettings settings_;
  std::optional<LogRing> ring_;
  std::atomic<std::uint64_t> written_{0}, dropped_{0}, lost_{0};

  // for the writer only
  std::optional<LogFile> candump_;
  std::array<std::optional<LogFile>, kLinks> tlogs_;
  std::array<PacketSplitter, 2 * kLinks> splitters_;
  std::array<std::uint8_t, 65536> scratch_{};

  FirstError error_;
  FileDescriptor stop_;
  pthread_t writer_{};
};

/// The interface name for the candump log: can0 for socketcan:can0, mcast0 for mcast:0.
std::string candump_name(std::string_view can_address);

}  // namespace flotilla::target
