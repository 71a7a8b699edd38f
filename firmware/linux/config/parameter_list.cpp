// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstring>
#include <sstream>
#include <string_view>
#include <vector>

#include "linux/config/config_values.hpp"
#include "linux/files/durable_file.hpp"

namespace flotilla::target {
namespace {

constexpr std::size_t kPlain = 2, kGroundControl = 5;  // columns

/// The words of a line, separated by blanks, tabs or commas; a # begins a comment.
std::vector<std::string> words_of(std::string line) {
  line.erase(std::min(line.find('#'), line.size()));
  for (char& c : line) {
    if (c == ',') c = ' ';
  }
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

void read_line(const std::vector<std::string>& words, ParameterOverrides& listed) {
  if (words.empty()) return;
  if (words.size() != kPlain && words.size() != kGroundControl) {
    throw ValueError("neither NAME,VALUE nor QGroundControl's five columns");
  }
  const std::size_t at = words.size() == kPlain ? 0 : 2;
  const std::string &name = words[at], &value = words[at + 1];
  const float set = parameter_value(name, number<double>(value), value);
  const auto [before, is_new] = listed.emplace(name, set);
  if (!is_new && before->second != set) {
    throw ValueError(name + " has another value above: keep one of the two lines");
  }
}

}  // namespace

void read_parameter_list(const std::string& file, ParameterOverrides& param) {
  const FileContent content = read_file(file);
  if (content.error != 0) {
    throw ConfigError(file + ": cannot be read: " + std::strerror(content.error));
  }
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // editors on Windows write it
  const bool marked = content.text.starts_with(kByteOrderMark);
  std::istringstream lines(content.text.substr(marked ? kByteOrderMark.size() : 0));
  ParameterOverrides listed;
  int count = 0;
  for (std::string line; std::getline(lines, line);) {
    ++count;
    try {
      read_line(words_of(line), listed);
    } catch (const ValueError& error) {
      throw ConfigError(file + ":" + std::to_string(count) + ": " + error.what());
    }
  }
  for (const auto& [name, value] : listed) param[name] = value;
}

}  // namespace flotilla::target
