// SPDX-License-Identifier: MIT
// Small files that are either the old one or the new one, whatever happens in between.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace flotilla::target {

/// What was read, or why it was not: `error` is an errno, 0 where all is well.
struct FileContent {
  int error = 0;
  std::string text;
};

constexpr std::size_t kChecksumLineSize = std::string_view("crc32 = 89ABCDEF\n").size();

/// The last line of a file whose other lines are `body`: by it a damaged file is known.
std::string checksum_line(std::string_view body);

/// The whole of a regular file of at most `most_bytes` (EFBIG beyond).
FileContent read_file(const std::filesystem::path& path, std::size_t most_bytes = 1U << 20U);

/// `path` with something behind its name, in the same directory.
std::filesystem::path beside(const std::filesystem::path& path, std::string_view suffix);

/// Makes the directory where it is missing, writes `path.new`, syncs it, renames it to `path`, syncs
/// the directory. What went wrong, as a sentence. Blocks for as long as the disk takes.
std::optional<std::string> replace_file(const std::filesystem::path& path,
                                        std::string_view content);

}  // namespace flotilla::target
