// SPDX-License-Identifier: MIT
#include "linux/logs/line_writer.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <climits>

namespace flotilla::target {
namespace {

constexpr std::size_t kRingBytes = 64U << 10U, kMaxWaiting = 4096, kLongest = 1024;

}  // namespace

LineWriter::LineWriter()
    : ring_(kRingBytes),
      thread_(std::chrono::milliseconds(50), [this] { drain(); }, "the messages") {}

void LineWriter::put(std::string_view line) {
  const auto size = static_cast<std::uint16_t>(std::min(line.size(), kLongest));
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(line.data());
  if (!ring_.put({0, size, 0}, {bytes, size})) dropped_.fetch_add(1, std::memory_order_relaxed);
}

void LineWriter::drain() {
  std::array<std::uint8_t, 65536> line;
  while (waiting_.size() < kMaxWaiting) {
    const auto record = ring_.take(line);
    if (!record) break;
    waiting_ += "flotillad: ";
    waiting_.append(reinterpret_cast<const char*>(line.data()), record->size);
    waiting_ += '\n';
  }
  if (waiting_.size() < kMaxWaiting) {
    if (const auto dropped = dropped_.exchange(0, std::memory_order_relaxed)) {
      waiting_ += "flotillad: " + std::to_string(dropped) + " messages dropped: nobody read them\n";
    }
  }
  write();
}

/// A ready pipe takes PIPE_BUF bytes without blocking, so the program's end never waits for a
/// reader.
void LineWriter::write() {
  while (!waiting_.empty()) {
    pollfd stderr_is{STDERR_FILENO, POLLOUT, 0};
    if (::poll(&stderr_is, 1, 0) <= 0) return;
    const std::size_t size = std::min<std::size_t>(waiting_.size(), PIPE_BUF);
    const ssize_t written = ::write(STDERR_FILENO, waiting_.data(), size);
    if (written < 0 && (errno == EAGAIN || errno == EINTR)) return;
    waiting_.erase(0, written < 0 ? waiting_.size() : static_cast<std::size_t>(written));
  }
}

}  // namespace flotilla::target
