// SPDX-License-Identifier: MIT
// Saves the assigned node ids across restarts.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "link/dronecan/node_id_server.hpp"
#include "linux/files/list_saver.hpp"

namespace flotilla::target {

/// A text file: one "UNIQUE-ID NODE" a line, the id in hexadecimal. Malformed lines are ignored: a
/// node missing from the table is assigned a new id.
class NodeTable {
 public:
  /// Throws std::system_error if the saver's thread cannot be started.
  explicit NodeTable(const std::filesystem::path& path,
                     std::chrono::milliseconds every = std::chrono::seconds(5));

  /// At the start; waits for the disk.
  void load(link::NodeIdServer& server);

  /// Saves the table if it has grown. Never blocks; false: try again.
  bool save(const link::NodeIdServer& server);

  /// The first error with the file, once. Writing is retried.
  std::optional<std::string> error() { return saver_.error(); }

 private:
  std::filesystem::path path_;
  std::size_t saved_ = 0;
  ListSaver<link::NodeIdServer::Entry> saver_;
};

}  // namespace flotilla::target
