// SPDX-License-Identifier: MIT
#include "linux/files/node_table.hpp"

#include <array>
#include <cstdio>
#include <sstream>
#include <utility>

#include "linux/files/durable_file.hpp"

namespace flotilla::target {

void NodeTable::load(link::NodeIdServer& server) {
  std::istringstream lines(read_file(path_).text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string unique_id;
    unsigned node = 0;
    link::NodeIdServer::Entry entry;
    if (!(words >> unique_id >> node)) continue;
    if (unique_id.size() != 2 * entry.unique_id.size() || node > 127) continue;
    bool whole = true;
    for (std::size_t i = 0; i < entry.unique_id.size(); ++i) {
      unsigned byte = 0;
      whole = whole && std::sscanf(unique_id.c_str() + 2 * i, "%2x", &byte) == 1;
      entry.unique_id[i] = static_cast<std::uint8_t>(byte);
    }
    entry.node = static_cast<std::uint8_t>(node);
    if (whole) server.restore(entry);
  }
  saved_ = server.table().size();
}

std::string NodeTable::save_if_changed(const link::NodeIdServer& server) {
  if (server.table().size() == saved_) return {};
  std::string text;
  for (const auto& entry : server.table()) {
    std::array<char, 4> digits{};
    for (const std::uint8_t byte : entry.unique_id) {
      std::snprintf(digits.data(), digits.size(), "%02x", unsigned{byte});
      text += digits.data();
    }
    text += " " + std::to_string(entry.node) + "\n";
  }
  const auto fault = replace_file(path_, text);
  if (!fault) saved_ = server.table().size();
  const bool known = std::exchange(faulty_, fault.has_value());
  return fault && !known ? *fault : std::string();
}

}  // namespace flotilla::target
