// SPDX-License-Identifier: MIT
#include "linux/files/signing_time.hpp"

#include <cerrno>
#include <charconv>
#include <cstring>
#include <ctime>
#include <exception>
#include <string_view>
#include <utility>

#include "linux/files/durable_file.hpp"
#include "linux/system/host_clock.hpp"

namespace flotilla::target {
namespace {

constexpr std::string_view kTitle = "flotilla-signing-time 1 ";

std::string text_of(std::uint64_t timestamp) {
  const std::string body = std::string(kTitle) + std::to_string(timestamp) + "\n";
  return body + checksum_line(body);
}

bool clock_is_set_now() { return clock_is_set({}, std::time(nullptr)); }

}  // namespace

StoredSigningTime load_signing_time(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  const FileContent content = read_file(path);
  if (content.error == ENOENT) return {};
  if (content.error != 0) {
    return {0, name + " cannot be read: " + std::strerror(content.error) + "; not used"};
  }
  std::uint64_t timestamp = 0;
  if (content.text.starts_with(kTitle)) {
    const char* end = content.text.data() + content.text.size();
    std::from_chars(content.text.data() + kTitle.size(), end, timestamp);
  }
  if (content.text != text_of(timestamp)) return {0, name + " is damaged; not used"};
  return {timestamp, {}};
}

SigningTime::SigningTime(std::filesystem::path path, std::uint64_t timestamp,
                         std::chrono::milliseconds every)
    : path_(std::move(path)),
      timestamp_(timestamp),
      clock_is_set_(clock_is_set_now()),
      writer_(
          every,
          [this] {
            write();
            clock_is_set_.store(clock_is_set_now(), std::memory_order_relaxed);
          },
          "signing-time") {}

void SigningTime::write() {
  try {
    const std::string text = text_of(timestamp_.load(std::memory_order_relaxed));
    if (const auto fault = replace_file(path_, text)) error_.put(*fault);
  } catch (const std::exception& error) {  // out of memory: retried as well
    error_.put(error.what());
  }
}

}  // namespace flotilla::target
