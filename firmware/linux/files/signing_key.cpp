// SPDX-License-Identifier: MIT
#include "linux/files/signing_key.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "linux/system/file_descriptor.hpp"

namespace flotilla::target {
namespace {

constexpr std::size_t kKeyBytes = std::tuple_size_v<link::SigningKey>;

/// Why a file with these attributes cannot keep a secret; nothing if it can.
std::optional<std::string> indiscretion(const struct stat& about) {
  if (!S_ISREG(about.st_mode)) return "is not a regular file";
  if (about.st_uid != ::geteuid() && about.st_uid != 0) {
    return "belongs to user " + std::to_string(about.st_uid) + " (allowed: this user or root)";
  }
  const unsigned mode = about.st_mode & 07777U;
  if ((mode & 077U) == 0) return std::nullopt;
  std::array<char, 8> octal{};
  std::snprintf(octal.data(), octal.size(), "%04o", mode);
  return "has mode " + std::string(octal.data()) +
         ": others can access the key (allowed: nothing for group and others; chmod 600 it, and "
         "better make a new key)";
}

/// 32 random bytes are practically never all hexadecimal digits.
bool is_half_a_key(std::string_view content) {
  if (content.ends_with('\n')) content.remove_suffix(1);
  return (content.size() == kKeyBytes || content.size() == kKeyBytes - 1) &&
         content.find_first_not_of("0123456789abcdefABCDEF") == std::string_view::npos;
}

std::optional<link::SigningKey> parse(std::string_view content) {
  link::SigningKey key{};
  if (content.size() == kKeyBytes) {
    std::memcpy(key.data(), content.data(), kKeyBytes);
    return key;
  }
  if (content.ends_with('\n')) content.remove_suffix(1);
  if (content.size() != 2 * kKeyBytes) return std::nullopt;
  for (std::size_t i = 0; i < kKeyBytes; ++i) {
    const char* digits = content.data() + 2 * i;
    const auto [end, error] = std::from_chars(digits, digits + 2, key[i], 16);
    if (error != std::errc{} || end != digits + 2) return std::nullopt;
  }
  return key;
}

}  // namespace

link::SigningKey read_signing_key(const std::filesystem::path& path) {
  const auto complain = [&](const std::string& what) {
    throw std::runtime_error("signing-key " + path.string() + " " + what);
  };
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat about{};
  std::array<char, 2 * kKeyBytes + 2> content{};
  ssize_t size = 0;
  if (file && ::fstat(file.get(), &about) == 0) {
    if (const auto fault = indiscretion(about)) complain(*fault);
    size = ::read(file.get(), content.data(), content.size());
  }
  if (!file || size < 0) complain(std::string("cannot be read: ") + std::strerror(errno));
  const std::string_view text(content.data(), static_cast<std::size_t>(size));
  const std::string allowed = " (allowed: 32 bytes, or 64 hexadecimal digits)";
  if (is_half_a_key(text)) complain("is half of a hexadecimal key" + allowed);
  const auto key = parse(text);
  if (!key) complain("is not a key" + allowed);
  return *key;
}

}  // namespace flotilla::target
