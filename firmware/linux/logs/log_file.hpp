// SPDX-License-Identifier: MIT
// A series of numbered files with a limited total size; each record is whole in one file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "linux/system/file_descriptor.hpp"

namespace flotilla::target {

/// `prefix-00001.ext`, `prefix-00002.ext`, …; each process begins a new one.
struct LogSeries {
  std::filesystem::path directory;
  std::string prefix;
  std::string extension;      ///< with its dot
  std::uint64_t file_bytes;   ///< a file that would grow beyond this is closed
  std::uint64_t total_bytes;  ///< the oldest files are removed so that the total stays below this
};

class LogFile {
 public:
  explicit LogFile(LogSeries series);
  ~LogFile() { close(); }
  LogFile(const LogFile&) = delete;
  LogFile& operator=(const LogFile&) = delete;

  /// Buffers the record, and flushes when the buffer is full. Records that could not be written are
  /// lost and counted.
  void append(std::span<const std::uint8_t> record);

  /// Passes all records to the operating system: they survive the end of this process.
  void flush();

  /// Waits for the disk: the records survive a power cut.
  void sync();

  void close();

  /// After a failure nothing is written until this is called.
  void try_again() { broken_ = false; }

  std::uint64_t written() const { return written_; }  ///< records
  std::uint64_t lost() const { return lost_; }        ///< records
  /// The first error.
  const std::optional<std::string>& fault() const { return fault_; }

 private:
  bool open();
  std::vector<std::uint64_t> make_room();
  std::filesystem::path path(std::uint64_t number) const;
  void fail(const std::filesystem::path& where, int error);

  LogSeries series_;
  FileDescriptor file_;
  std::filesystem::path path_;
  std::uint64_t size_ = 0;  ///< of the open file, whole records only
  std::vector<std::uint8_t> buffer_;
  std::uint64_t buffered_ = 0;  ///< records
  std::uint64_t written_ = 0;
  std::uint64_t lost_ = 0;
  bool broken_ = false;
  std::optional<std::string> fault_;
};

}  // namespace flotilla::target
