// SPDX-License-Identifier: MIT
#include "linux/logs/log_reader.hpp"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <limits>
#include <string>
#include <system_error>
#include <utility>

namespace flotilla::target {
namespace {

constexpr std::chrono::milliseconds kLookEvery{20};

/// As Logs names them.
bool is_log(const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  return (name.starts_with("mavlink") && name.ends_with(".tlog")) ||
         (name.starts_with("can-") && name.ends_with(".log"));
}

std::uint32_t clipped(std::int64_t number) {
  constexpr std::int64_t kMax = std::numeric_limits<std::uint32_t>::max();
  return static_cast<std::uint32_t>(std::clamp<std::int64_t>(number, 0, kMax));
}

std::uint32_t unix_s(std::filesystem::file_time_type time) {
  const auto system = std::chrono::file_clock::to_sys(time);
  return clipped(std::chrono::floor<std::chrono::seconds>(system).time_since_epoch().count());
}

}  // namespace

LogReader::LogReader(std::filesystem::path directory)
    : directory_(std::move(directory)),
      reader_(kLookEvery, [this] { work(); }, "the reader of logs") {}

void LogReader::ask(const Request& request) {
  if (state_.load(std::memory_order_acquire) != State::kIdle) return;
  request_ = request;
  state_.store(State::kAsked, std::memory_order_release);
}

std::optional<LogReader::Answer> LogReader::take() {
  if (state_.load(std::memory_order_acquire) != State::kAnswered) return std::nullopt;
  state_.store(State::kIdle, std::memory_order_relaxed);
  return Answer{request_, logs_, bytes_};
}

void LogReader::work() {
  if (state_.load(std::memory_order_acquire) != State::kAsked) return;
  request_.list ? list() : read();
  state_.store(State::kAnswered, std::memory_order_release);
}

/// The oldest first.
void LogReader::list() {
  logs_.clear();
  std::error_code error;
  for (std::filesystem::directory_iterator entry(directory_, error), end; !error && entry != end;
       entry.increment(error)) {
    if (!is_log(entry->path()) || !entry->is_regular_file(error)) continue;
    std::error_code gone;
    const auto size = entry->file_size(gone);
    const auto time = entry->last_write_time(gone);
    if (gone) continue;
    logs_.push_back({entry->path(), clipped(static_cast<std::int64_t>(size)), unix_s(time)});
  }
  std::ranges::sort(logs_, {}, [](const Log& log) { return std::pair(log.time_s, log.file); });
}

void LogReader::read() {
  bytes_.clear();
  if (request_.log >= logs_.size()) return;
  std::ifstream file(logs_[request_.log].file, std::ios::binary);
  if (!file.seekg(request_.offset)) return;
  bytes_.resize(request_.bytes);
  file.read(reinterpret_cast<char*>(bytes_.data()), static_cast<std::streamsize>(bytes_.size()));
  bytes_.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
}

}  // namespace flotilla::target
