// SPDX-License-Identifier: MIT
#include "target/linux/signing_time.hpp"

#include <poll.h>
#include <sys/eventfd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <exception>
#include <string_view>
#include <system_error>
#include <utility>

#include "target/linux/background_thread.hpp"
#include "target/linux/durable_file.hpp"
#include "target/linux/parameter_file.hpp"

namespace flotilla::target {
namespace {

constexpr int kEvery_ms = 30'000;
constexpr std::string_view kTitle = "flotilla-signing-time 1 ";

std::string text_of(std::uint64_t timestamp) {
  const std::string body = std::string(kTitle) + std::to_string(timestamp) + "\n";
  std::array<char, 32> checksum{};
  std::snprintf(checksum.data(), checksum.size(), "crc32 = %08X\n",
                static_cast<unsigned>(crc32(body)));
  return body + checksum.data();
}

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

SigningTime::SigningTime(std::filesystem::path path, std::uint64_t timestamp)
    : path_(std::move(path)), timestamp_(timestamp), stop_(::eventfd(0, EFD_CLOEXEC)) {
  if (!stop_) throw std::system_error(errno, std::generic_category(), "eventfd of signing-time");
  writer_ = start_background_thread(&SigningTime::run, this, "signing-time");
}

SigningTime::~SigningTime() {
  ::eventfd_write(stop_.get(), 1);
  pthread_join(writer_, nullptr);
}

std::optional<std::string> SigningTime::complaint() {
  if (complained_ || !has_complaint_.load(std::memory_order_acquire)) return std::nullopt;
  complained_ = true;
  return std::move(complaint_);
}

void* SigningTime::run(void* self) {
  static_cast<SigningTime*>(self)->write_until_stopped();
  return nullptr;
}

void SigningTime::write_until_stopped() {
  for (bool stopped = false; !stopped;) {
    write();
    pollfd stop{stop_.get(), POLLIN, 0};
    stopped = ::poll(&stop, 1, kEvery_ms) > 0;
  }
  write();
}

void SigningTime::write() {
  std::optional<std::string> fault;
  try {
    fault = replace_file(path_, text_of(timestamp_.load(std::memory_order_relaxed)));
  } catch (const std::exception& error) {  // out of memory: tried again as well
    fault = error.what();
  }
  if (!fault || has_complaint_.load(std::memory_order_relaxed)) return;
  complaint_ = std::move(*fault);
  has_complaint_.store(true, std::memory_order_release);
}

}  // namespace flotilla::target
