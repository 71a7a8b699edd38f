// SPDX-License-Identifier: MIT
#include "linux/files/durable_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>
#include <utility>

#include "link/mavlink/crc32.hpp"
#include "linux/system/file_descriptor.hpp"

namespace flotilla::target {
namespace {

bool write_all(int fd, std::string_view content) {
  while (!content.empty()) {
    const ssize_t written = ::write(fd, content.data(), content.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    content.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

std::string sentence(const std::filesystem::path& path, const char* what) {
  return path.string() + " " + what + ": " + std::strerror(errno);
}

}  // namespace

std::string checksum_line(std::string_view body) {
  std::array<char, kChecksumLineSize + 1> line{};
  std::snprintf(line.data(), line.size(), "crc32 = %08X\n",
                static_cast<unsigned>(link::ieee_crc32(body)));
  return line.data();
}

FileContent read_file(const std::filesystem::path& path, std::size_t most_bytes) {
  // O_NONBLOCK: does not wait for a writer if the path is a pipe.
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat about{};
  if (!file || ::fstat(file.get(), &about) != 0) return {errno, {}};
  if (S_ISDIR(about.st_mode)) return {EISDIR, {}};
  if (!S_ISREG(about.st_mode)) return {EINVAL, {}};
  if (static_cast<std::size_t>(about.st_size) > most_bytes) return {EFBIG, {}};
  std::string text(static_cast<std::size_t>(about.st_size), '\0');
  std::size_t size = 0;
  while (size < text.size()) {
    const ssize_t got = ::read(file.get(), text.data() + size, text.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return {errno, {}};
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  text.resize(size);
  return {0, std::move(text)};
}

std::filesystem::path beside(const std::filesystem::path& path, std::string_view suffix) {
  std::filesystem::path other = path;
  other += suffix;
  return other;
}

std::optional<std::string> replace_file(const std::filesystem::path& path,
                                        std::string_view content) {
  const auto fresh = beside(path, ".new");
  const auto directory = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  std::error_code ignored;  // without a directory, opening the file fails
  std::filesystem::create_directories(directory, ignored);
  {
    const FileDescriptor file(
        ::open(fresh.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
    if (!file || !write_all(file.get(), content) || ::fsync(file.get()) != 0) {
      return sentence(fresh, "cannot be written");
    }
  }
  if (std::rename(fresh.c_str(), path.c_str()) != 0) return sentence(path, "cannot be replaced");
  const FileDescriptor folder(::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder || ::fsync(folder.get()) != 0) return sentence(directory, "cannot be synced");
  return std::nullopt;
}

}  // namespace flotilla::target
