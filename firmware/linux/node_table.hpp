// SPDX-License-Identifier: MIT
// The node ids that were given away, kept over a restart.
#pragma once

#include <filesystem>
#include <string>
#include <utility>

#include "link/dronecan/node_id_server.hpp"

namespace flotilla::target {

/// A text file: one "UNIQUE-ID NODE" a line, the id in hexadecimal. Lines that make no sense are
/// passed over: a node that is not in the table gets an id anew.
class NodeTable {
 public:
  explicit NodeTable(std::filesystem::path path) : path_(std::move(path)) {}

  void load(link::NodeIdServer& server);

  /// Writes the table where it has grown since, until the disk has taken it; what went wrong, said
  /// once, or nothing.
  std::string save_if_changed(const link::NodeIdServer& server);

 private:
  std::filesystem::path path_;
  std::size_t saved_ = 0;
  bool faulty_ = false;  ///< the disk did not take it last time
};

}  // namespace flotilla::target
