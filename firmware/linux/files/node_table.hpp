// SPDX-License-Identifier: MIT
// Saves the assigned node ids across restarts.
#pragma once

#include <filesystem>
#include <string>
#include <utility>

#include "link/dronecan/node_id_server.hpp"

namespace flotilla::target {

/// A text file: one "UNIQUE-ID NODE" a line, the id in hexadecimal. Malformed lines are ignored: a
/// node missing from the table is assigned a new id.
class NodeTable {
 public:
  explicit NodeTable(std::filesystem::path path) : path_(std::move(path)) {}

  void load(link::NodeIdServer& server);

  /// Writes the table if it has grown, and retries after errors. Returns an error once, else "".
  std::string save_if_changed(const link::NodeIdServer& server);

 private:
  std::filesystem::path path_;
  std::size_t saved_ = 0;
  bool faulty_ = false;  ///< the last write failed
};

}  // namespace flotilla::target
