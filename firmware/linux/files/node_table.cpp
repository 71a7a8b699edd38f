// SPDX-License-Identifier: MIT
#include "linux/files/node_table.hpp"

#include <array>
#include <cstdio>
#include <span>
#include <sstream>

#include "linux/files/durable_file.hpp"

namespace flotilla::target {
namespace {

using Entry = link::NodeIdServer::Entry;

constexpr std::size_t kMaxEntries = 128;

std::string table_text(std::span<const Entry> table) {
  std::string text;
  for (const Entry& entry : table) {
    std::array<char, 4> digits{};
    for (const std::uint8_t byte : entry.unique_id) {
      std::snprintf(digits.data(), digits.size(), "%02x", unsigned{byte});
      text += digits.data();
    }
    text += " " + std::to_string(entry.node) + "\n";
  }
  return text;
}

}  // namespace

NodeTable::NodeTable(const std::filesystem::path& path, std::chrono::milliseconds every)
    : path_(path), saver_(path, kMaxEntries, table_text, every, "the node ids' saver") {}

void NodeTable::load(link::NodeIdServer& server) {
  std::istringstream lines(read_file(path_).text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string unique_id;
    unsigned node = 0;
    Entry entry;
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

bool NodeTable::save(const link::NodeIdServer& server) {
  const auto table = server.table();
  if (table.size() == saved_) return true;
  if (!saver_.put(table)) return false;
  saved_ = table.size();
  return true;
}

}  // namespace flotilla::target
