// SPDX-License-Identifier: MIT
#include "linux/logs/logs.hpp"

#include <poll.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <exception>
#include <system_error>
#include <utility>

#include "linux/system/background_thread.hpp"

namespace flotilla::target {
namespace {

constexpr int kDrainEvery_ms = 100;
constexpr auto kTryAgainEvery = std::chrono::seconds(1);
constexpr auto kSyncEvery = std::chrono::seconds(5);
constexpr std::uint8_t kCan = 255;  // channels below: MAVLink, 2 · link + direction
constexpr std::size_t kCanIdBytes = 4;

LogSeries tlog(const LogSettings& settings, std::size_t link) {
  return {settings.directory, "mavlink" + std::to_string(link), ".tlog", settings.file_bytes,
          settings.total_bytes / settings.links};
}

}  // namespace

Logs::Logs(LogSettings settings) : settings_(std::move(settings)) {
  if (settings_.directory.empty()) return;
  ring_.emplace(settings_.ring_bytes);
  settings_.links = std::min(settings_.links, kLinks);
  for (std::size_t i = 0; i < settings_.links; ++i) tlogs_[i].emplace(tlog(settings_, i));
  candump_.emplace(
      LogSeries{settings_.directory, "can", ".log", settings_.file_bytes, settings_.total_bytes});
  stop_ = FileDescriptor(::eventfd(0, EFD_CLOEXEC));
  if (!stop_) throw std::system_error(errno, std::generic_category(), "eventfd of the logs");
  writer_ = start_background_thread(&Logs::run, this, "the logs");
}

Logs::~Logs() {
  if (!stop_) return;
  ::eventfd_write(stop_.get(), 1);
  pthread_join(writer_, nullptr);
}

void Logs::put(std::uint8_t channel, std::span<const std::uint8_t> payload, std::int64_t unix_us) {
  const LogRecord record{unix_us, static_cast<std::uint16_t>(payload.size()), channel};
  if (!ring_->put(record, payload)) dropped_.fetch_add(1, std::memory_order_relaxed);
}

void Logs::mavlink(std::size_t link, Direction direction, std::span<const std::uint8_t> bytes,
                   std::int64_t unix_us) {
  if (!ring_ || link >= settings_.links) return;
  const auto channel = static_cast<std::uint8_t>(2 * link + static_cast<std::size_t>(direction));
  constexpr std::size_t kMax = 4096;
  for (; !bytes.empty(); bytes = bytes.subspan(std::min(kMax, bytes.size()))) {
    put(channel, bytes.first(std::min(kMax, bytes.size())), unix_us);
  }
}

void Logs::can(const link::CanFrame& frame, std::int64_t unix_us) {
  if (!ring_) return;
  std::array<std::uint8_t, kCanIdBytes + 8> payload{};
  std::memcpy(payload.data(), &frame.id, kCanIdBytes);
  std::copy(frame.bytes().begin(), frame.bytes().end(), payload.begin() + kCanIdBytes);
  put(kCan, std::span(payload).first(kCanIdBytes + frame.size), unix_us);
}

LogCounters Logs::counters() const {
  return {written_.load(std::memory_order_relaxed), dropped_.load(std::memory_order_relaxed),
          lost_.load(std::memory_order_relaxed)};
}

void* Logs::run(void* self) {
  auto& logs = *static_cast<Logs*>(self);
  try {
    logs.write_until_stopped();
  } catch (const std::exception& error) {  // the boat sails on; the ring fills, drops are counted
    logs.error_.put(std::string("logs end: ") + error.what());
  }
  return nullptr;
}

template <class F>
void Logs::each_file(F&& f) {
  for (std::size_t i = 0; i < settings_.links; ++i) f(*tlogs_[i]);
  f(*candump_);
}

void Logs::write_until_stopped() {
  using Clock = std::chrono::steady_clock;
  auto try_again_at = Clock::now() + kTryAgainEvery, sync_at = Clock::now() + kSyncEvery;
  for (bool stopped = false; !stopped;) {
    pollfd stop{stop_.get(), POLLIN, 0};
    stopped = ::poll(&stop, 1, kDrainEvery_ms) > 0;
    drain();
    const auto now = Clock::now();
    if (now >= try_again_at) {
      each_file([](LogFile& file) { file.try_again(); });
      try_again_at = now + kTryAgainEvery;
    }
    if (now >= sync_at) {
      each_file([](LogFile& file) { file.sync(); });
      sync_at = now + kSyncEvery;
    }
  }
  each_file([](LogFile& file) { file.close(); });
  publish();
}

void Logs::drain() {
  while (const auto record = ring_->take(scratch_)) {
    const std::span<const std::uint8_t> payload(scratch_.data(), record->size);
    record->channel == kCan ? write_can(*record, payload) : write_mavlink(*record, payload);
  }
  each_file([](LogFile& file) { file.flush(); });
  publish();
}

void Logs::write_mavlink(const LogRecord& record, std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kTimeBytes = 8, kLongestPacket = 10 + 255 + 2 + 13;
  std::array<std::uint8_t, kTimeBytes + kLongestPacket> out;
  const auto time = static_cast<std::uint64_t>(record.unix_us);
  for (std::size_t i = 0; i < kTimeBytes; ++i) {
    out[i] = static_cast<std::uint8_t>(time >> (8U * (kTimeBytes - 1 - i)));
  }
  splitters_[record.channel].split(bytes, [&](std::span<const std::uint8_t> packet) {
    if (holds_key(packet)) return;
    std::copy(packet.begin(), packet.end(), out.begin() + kTimeBytes);
    tlogs_[record.channel / 2]->append(std::span(out).first(kTimeBytes + packet.size()));
  });
}

void Logs::write_can(const LogRecord& record, std::span<const std::uint8_t> payload) {
  constexpr std::int64_t kMicro = 1000000;
  std::uint32_t id = 0;
  std::memcpy(&id, payload.data(), kCanIdBytes);
  std::array<char, 128> line;
  int size = std::snprintf(line.data(), line.size(), "(%010lld.%06lld) %.32s %08X#",
                           static_cast<long long>(record.unix_us / kMicro),
                           static_cast<long long>(record.unix_us % kMicro),
                           settings_.can_name.c_str(), static_cast<unsigned>(id));
  for (const std::uint8_t byte : payload.subspan(kCanIdBytes)) {
    size += std::snprintf(&line[static_cast<std::size_t>(size)], 3, "%02X", byte);
  }
  line[static_cast<std::size_t>(size++)] = '\n';
  candump_->append(
      {reinterpret_cast<const std::uint8_t*>(line.data()), static_cast<std::size_t>(size)});
}

void Logs::publish() {
  std::uint64_t written = 0, lost = 0;
  each_file([&](const LogFile& file) {
    written += file.written();
    lost += file.lost();
    if (file.fault()) error_.put(*file.fault());
  });
  written_.store(written, std::memory_order_relaxed);
  lost_.store(lost, std::memory_order_relaxed);
}

std::string candump_name(std::string_view can_address) {
  const std::size_t colon = can_address.find(':');
  const std::string_view scheme = can_address.substr(0, colon);
  std::string_view place = can_address.substr(colon == std::string_view::npos ? 0 : colon + 1);
  place = place.substr(0, place.find(':'));
  return scheme == "mcast" ? "mcast" + std::string(place) : std::string(place);
}

}  // namespace flotilla::target
