// SPDX-License-Identifier: MIT
#include "linux/logs/log_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <system_error>
#include <utility>

namespace flotilla::target {
namespace {

constexpr std::size_t kBufferBytes = 32U << 10U;
constexpr int kOpenTries = 100;

/// The number in "prefix-00012.ext"; nothing for any other name.
std::optional<std::uint64_t> number_of(const std::string& name, const LogSeries& series) {
  const std::string begin = series.prefix + "-";
  if (!name.starts_with(begin) || !name.ends_with(series.extension)) return std::nullopt;
  if (name.size() < begin.size() + series.extension.size()) return std::nullopt;
  const char* first = name.data() + begin.size();
  const char* last = name.data() + name.size() - series.extension.size();
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(first, last, number);
  return error == std::errc{} && end == last ? std::optional(number) : std::nullopt;
}

}  // namespace

LogFile::LogFile(LogSeries series) : series_(std::move(series)) { buffer_.reserve(kBufferBytes); }

std::filesystem::path LogFile::path(std::uint64_t number) const {
  std::array<char, 32> digits{};
  std::snprintf(digits.data(), digits.size(), "-%05llu", static_cast<unsigned long long>(number));
  return series_.directory / (series_.prefix + digits.data() + series_.extension);
}

void LogFile::fail(const std::filesystem::path& where, int error) {
  broken_ = true;
  lost_ += std::exchange(buffered_, 0);
  buffer_.clear();
  if (file_ && size_ == 0) ::unlink(path_.c_str());  // or a full disk would collect empty files
  file_ = FileDescriptor();
  if (!fault_) fault_ = "log " + where.string() + ": " + std::strerror(error);
}

/// Removes the oldest files until a new one fits; returns the numbers found, ascending.
std::vector<std::uint64_t> LogFile::make_room() {
  std::vector<std::uint64_t> numbers;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(series_.directory, error), end;
       !error && entry != end; entry.increment(error)) {
    const auto number = number_of(entry->path().filename().string(), series_);
    if (number && path(*number).filename() == entry->path().filename()) numbers.push_back(*number);
  }
  std::sort(numbers.begin(), numbers.end());
  std::uint64_t room = series_.total_bytes - std::min(series_.total_bytes, series_.file_bytes);
  auto keep = numbers.end();
  while (keep != numbers.begin()) {
    const auto size = std::filesystem::file_size(path(*(keep - 1)), error);
    if (!error && size > room) break;
    if (!error) room -= size;
    --keep;
  }
  for (auto old = numbers.begin(); old != keep; ++old) std::filesystem::remove(path(*old), error);
  return numbers;
}

bool LogFile::open() {
  std::error_code error;
  std::filesystem::create_directories(series_.directory, error);
  if (error) {
    fail(series_.directory, error.value());
    return false;
  }
  const std::vector<std::uint64_t> numbers = make_room();
  std::uint64_t next = numbers.empty() ? 1 : numbers.back() + 1;
  for (int i = 0; i < kOpenTries; ++i, ++next) {  // another process may take the same number
    path_ = path(next);
    file_ = FileDescriptor(::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0640));
    if (file_ || errno != EEXIST) break;
  }
  if (!file_) fail(path_, errno);
  size_ = 0;
  return static_cast<bool>(file_);
}

void LogFile::append(std::span<const std::uint8_t> record) {
  if (buffer_.size() + record.size() > kBufferBytes) flush();
  if (!broken_ && file_ && size_ + buffer_.size() + record.size() > series_.file_bytes) close();
  if (broken_ || (!file_ && !open())) {
    ++lost_;
    return;
  }
  buffer_.insert(buffer_.end(), record.begin(), record.end());
  ++buffered_;
}

void LogFile::flush() {
  std::size_t done = 0;
  while (done < buffer_.size()) {
    const ssize_t written = ::write(file_.get(), buffer_.data() + done, buffer_.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      const int error = written < 0 ? errno : EIO;
      // No partial record may stay behind. Whole ones are truncated with it, and counted as lost.
      if (::ftruncate(file_.get(), static_cast<off_t>(size_)) != 0) errno = error;
      return fail(path_, error);
    }
    done += static_cast<std::size_t>(written);
  }
  size_ += buffer_.size();
  written_ += std::exchange(buffered_, 0);
  buffer_.clear();
}

void LogFile::sync() {
  if (file_ && ::fdatasync(file_.get()) != 0) fail(path_, errno);
}

void LogFile::close() {
  flush();
  sync();
  file_ = FileDescriptor();
}

}  // namespace flotilla::target
