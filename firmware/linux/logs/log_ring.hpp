// SPDX-License-Identifier: MIT
// Lock-free queue of records from the control loop to the log writer: one producer, one consumer.
#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>

namespace flotilla::target {

struct LogRecord {
  std::int64_t unix_us = 0;
  std::uint16_t size = 0;    ///< bytes of payload
  std::uint8_t channel = 0;  ///< kind of payload; opaque to the ring
};

/// Allocates and touches all its memory on construction.
class LogRing {
 public:
  /// Capacity, rounded up to a power of two.
  explicit LogRing(std::size_t bytes)
      : capacity_(std::bit_ceil(bytes)), bytes_(std::make_unique<std::uint8_t[]>(capacity_)) {}

  /// For the producer. Returns false and stores nothing if there is no room.
  bool put(const LogRecord& record, std::span<const std::uint8_t> payload) {
    const std::size_t put = put_.load(std::memory_order_relaxed);
    const std::size_t taken = taken_.load(std::memory_order_acquire);
    if (capacity_ - (put - taken) < sizeof record + payload.size()) return false;
    copy_in(put, &record, sizeof record);
    copy_in(put + sizeof record, payload.data(), payload.size());
    put_.store(put + sizeof record + payload.size(), std::memory_order_release);
    return true;
  }

  /// For the consumer. Copies the payload to the front of `out`, which must hold 65535 bytes.
  std::optional<LogRecord> take(std::span<std::uint8_t> out) {
    const std::size_t taken = taken_.load(std::memory_order_relaxed);
    if (taken == put_.load(std::memory_order_acquire)) return std::nullopt;
    LogRecord record;
    copy_out(&record, taken, sizeof record);
    copy_out(out.data(), taken + sizeof record, record.size);
    taken_.store(taken + sizeof record + record.size, std::memory_order_release);
    return record;
  }

 private:
  // Positions count all bytes ever put or taken; their difference is right even after a wrap.
  void copy_in(std::size_t at, const void* from, std::size_t size) {
    const std::size_t begin = at & (capacity_ - 1), first = std::min(size, capacity_ - begin);
    if (size == 0) return;
    std::memcpy(&bytes_[begin], from, first);
    std::memcpy(&bytes_[0], static_cast<const std::uint8_t*>(from) + first, size - first);
  }
  void copy_out(void* to, std::size_t at, std::size_t size) const {
    const std::size_t begin = at & (capacity_ - 1), first = std::min(size, capacity_ - begin);
    if (size == 0) return;
    std::memcpy(to, &bytes_[begin], first);
    std::memcpy(static_cast<std::uint8_t*>(to) + first, &bytes_[0], size - first);
  }

  static constexpr std::size_t kCacheLine = 64;
  std::size_t capacity_;
  std::unique_ptr<std::uint8_t[]> bytes_;
  alignas(kCacheLine) std::atomic<std::size_t> put_{0};
  alignas(kCacheLine) std::atomic<std::size_t> taken_{0};
};

}  // namespace flotilla::target
