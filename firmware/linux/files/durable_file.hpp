// SPDX-License-Identifier: MIT
// Small files replaced atomically: after a crash the content is either the old or the new.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace flotilla::target {

/// The content read, or an errno; 0 on success.
struct FileContent {
  int error = 0;
  std::string text;
};

constexpr std::size_t kChecksumLineSize = std::string_view("crc32 = 89ABCDEF\n").size();

/// The last line of a file whose other lines are `body`; reveals damage.
std::string checksum_line(std::string_view body);

/// Reads a whole regular file of at most `most_bytes`; error EFBIG if it is larger.
FileContent read_file(const std::filesystem::path& path, std::size_t most_bytes = 1U << 20U);

/// `path` with a suffix to its name, in the same directory.
std::filesystem::path beside(const std::filesystem::path& path, std::string_view suffix);

/// Creates the directory if missing, writes `path.new`, syncs it, renames it to `path`, syncs the
/// directory. Returns an error as a sentence. Blocks for as long as the disk takes.
std::optional<std::string> replace_file(const std::filesystem::path& path,
                                        std::string_view content);

}  // namespace flotilla::target
