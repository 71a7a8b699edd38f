// SPDX-License-Identifier: MIT
#include "linux/config/config_values.hpp"
#include "linux/files/durable_file.hpp"

#define TOML_ENABLE_FORMATTERS 0
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <sstream>

namespace flotilla::target {
namespace {

/// The value if it has exactly that TOML type.
template <class T>
T typed(const toml::node& node, std::string_view type) {
  if (const auto value = node.value_exact<T>()) return *value;
  throw ValueError("must be " + std::string(type));
}

std::string toml_text(const toml::node& node) { return typed<std::string>(node, "a string"); }

std::string where(const std::string& file, const toml::source_region& region) {
  return file + ":" + std::to_string(region.begin.line) + ":" +
         std::to_string(region.begin.column) + ": ";
}

/// Runs `read` on a value; an error names the file, line and key.
template <class Read>
void at(const std::string& file, const std::string& key, const toml::node& node, Read read) {
  try {
    read(node);
  } catch (const ValueError& error) {
    throw ConfigError(where(file, node.source()) + key + ": " + error.what());
  }
}

void read_links(const std::string& file, const toml::node& node, Config& config) {
  const toml::array* list = node.as_array();
  if (list == nullptr) {
    throw ValueError("must be a list of strings, such as [\"udpin:0.0.0.0:14550\"]");
  }
  require_link_count(list->size());
  for (const toml::node& entry : *list) {
    at(file, "mavlink", entry,
       [&](const toml::node& n) { config.mavlink.push_back(mavlink_link(toml_text(n))); });
  }
}

void read_parameters(const std::string& file, const toml::node& node, Config& config) {
  const toml::table* table = node.as_table();
  if (table == nullptr) throw ValueError("must be a table: [param] and NAME = VALUE lines");
  for (const auto& [key, value] : *table) {
    const std::string name(key.str());
    at(file, "param", value, [&](const toml::node& n) {
      if (!n.is_number()) throw ValueError(name + " must be a number");
      const auto number = n.value<double>();
      std::ostringstream text;
      if (number) text << *number;
      config.param[name] = parameter_value(name, number, text.str());
    });
  }
}

struct Key {
  std::string_view name;
  void (*read)(const std::string& file, const toml::node&, Config&);
};

constexpr std::array kKeys{
    Key{"can", [](auto&, auto& n, Config& c) { c.can = can_address(toml_text(n)); }},
    Key{"mavlink", read_links},
    Key{"state-dir", [](auto&, auto& n, Config& c) { c.state_dir = toml_text(n); }},
    Key{"signing-key", [](auto&, auto& n, Config& c) { c.signing_key = toml_text(n); }},
    Key{"log", [](auto&, auto& n, Config& c) { c.log = toml_text(n); }},
    Key{"stats", [](auto&, auto& n, Config& c) { c.stats = toml_text(n); }},
    Key{"stop-gpio", [](auto&, auto& n, Config& c) { c.stop = stop_line(toml_text(n)); }},
    Key{"priority",
        [](auto&, auto& n, Config& c) {
          c.priority = priority_value(typed<std::int64_t>(n, "a whole number"));
        }},
    Key{"lock-memory",
        [](auto&, auto& n, Config& c) { c.lock_memory = typed<bool>(n, "true or false"); }},
    Key{"param", read_parameters},
};

toml::table parse(const std::string& file) {
  const FileContent content = read_file(file);
  if (content.error != 0) {
    throw ConfigError(file + ": cannot be read: " + std::strerror(content.error));
  }
  try {
    return toml::parse(content.text, file);
  } catch (const toml::parse_error& error) {
    throw ConfigError(where(file, error.source()) + std::string(error.description()));
  }
}

}  // namespace

Config read_config_file(const std::string& file) {
  Config config;
  const toml::table table = parse(file);
  for (const auto& [key, value] : table) {
    const auto known =
        std::find_if(kKeys.begin(), kKeys.end(), [&](const Key& k) { return k.name == key.str(); });
    if (known == kKeys.end()) {
      std::string allowed;
      for (const Key& k : kKeys) allowed += (allowed.empty() ? "" : ", ") + std::string(k.name);
      throw ConfigError(where(file, key.source()) + "unknown key \"" + std::string(key.str()) +
                        "\" (allowed: " + allowed + ")");
    }
    at(file, std::string(key.str()), value,
       [&](const toml::node& n) { known->read(file, n, config); });
  }
  return config;
}

}  // namespace flotilla::target
