// SPDX-License-Identifier: MIT
#include "linux/files/parameter_file.hpp"

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <utility>

#include "linux/files/durable_file.hpp"

namespace flotilla::target {
namespace {

constexpr std::string_view kTitle = "flotilla-parameters ";
constexpr std::string_view kFirstLine = "flotilla-parameters 1";
constexpr std::string_view kAllDefaults =
    "ALL PARAMETERS ARE DEFAULTS: check and save them before arming";

/// The shortest text that reads back as the same number.
std::string number_text(float value) {
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), end};
}

std::optional<float> number(std::string_view text) {
  float value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Removes and returns the first line.
std::string_view next_line(std::string_view& text) {
  const std::size_t end = text.find('\n');
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  return line;
}

/// The lines between title and checksum, or why they cannot be trusted.
struct Checked {
  std::string_view lines;
  std::string fault;
};

Checked check(std::string_view content) {
  if (content.empty()) return {{}, "is empty"};
  if (content.size() < kChecksumLineSize) return {{}, "is truncated"};
  std::string_view lines = content.substr(0, content.size() - kChecksumLineSize);
  if (content.substr(lines.size()) != checksum_line(lines)) {
    return {{}, "is damaged or was edited by hand (its checksum does not match)"};
  }
  const std::string_view title = next_line(lines);
  if (title != kFirstLine) {
    if (!title.starts_with(kTitle)) return {{}, "is not a parameter file"};
    return {{}, "has another format (\"" + std::string(title) + "\")"};
  }
  return {lines, {}};
}

/// Reads a line "NAME = VALUE"; notes a line that cannot be used.
void read_line(std::string_view line, const std::string& where, LoadedParameters& loaded,
               std::array<bool, app::kParameterList.size()>& seen) {
  const std::size_t equals = line.find(" = ");
  if (line.starts_with("MODE = ")) {
    loaded.notes.push_back(
        where + ": " + std::string(line) +
        " is ignored: the mode is no longer a parameter, set it from the ground station");
    return;
  }
  const app::ParameterInfo* info = app::find_parameter(line.substr(0, equals));
  if (info == nullptr || equals == std::string_view::npos) {
    loaded.unknown.emplace_back(line);
    loaded.notes.push_back(where + ": \"" + std::string(line.substr(0, equals)) +
                           "\" is unknown to this version and kept");
    return;
  }
  seen[static_cast<std::size_t>(info - app::kParameterList.data())] = true;
  const std::string_view text = line.substr(equals + 3);
  const auto value = number(text);
  if (value && app::is_valid(*info, *value)) {
    loaded.values.*info->member = *value;
    return;
  }
  loaded.must_be_confirmed = true;
  loaded.notes.push_back(where + ": " + std::string(info->name) + " = " + std::string(text) +
                         " is refused (allowed: " + number_text(info->least) + " to " +
                         number_text(info->greatest) + (info->whole() ? ", whole" : "") +
                         "); using the default " + number_text(info->default_value()));
}

/// Notes parameters that are missing because an older version wrote the file.
void note_missing(const std::array<bool, app::kParameterList.size()>& seen,
                  const std::string& where, LoadedParameters& loaded) {
  std::string names;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen[i]) continue;
    names += (names.empty() ? "" : ", ") + std::string(app::kParameterList[i].name);
  }
  if (!names.empty()) loaded.notes.push_back(where + ": not in the file, so default: " + names);
}

/// In files older than NAV_COMPID, 0 was the default of these parameters; since then, 0 has another
/// meaning.
void renew_defaults(const std::array<bool, app::kParameterList.size()>& seen,
                    const std::string& where, LoadedParameters& loaded) {
  const auto has = [&](std::string_view name) {
    return seen[static_cast<std::size_t>(app::find_parameter(name) - app::kParameterList.data())];
  };
  if (has("NAV_COMPID")) return;
  for (const std::string_view name : {"NAV_LAG_S", "FS_SEP_M"}) {
    const app::ParameterInfo& info = *app::find_parameter(name);
    float& value = loaded.values.*info.member;
    if (!has(name) || value != 0) continue;
    value = info.default_value();
    loaded.notes.push_back(where + ": " + std::string(name) +
                           " = 0 from an older version is replaced by the new default " +
                           number_text(value));
  }
}

enum class Found : std::uint8_t { kGood, kBad, kAbsent };

/// Reads one version into `loaded`; a bad one adds only its note.
Found read_version(const std::filesystem::path& path, LoadedParameters& loaded) {
  const std::string where = path.filename().string();
  const auto bad = [&](std::string_view why) {
    loaded.notes.push_back(where + " " + std::string(why));
    return Found::kBad;
  };
  const FileContent content = read_file(path);
  if (content.error == ENOENT) return Found::kAbsent;
  if (content.error != 0) {
    return bad(std::string("cannot be read: ") + std::strerror(content.error));
  }
  Checked checked = check(content.text);
  if (!checked.fault.empty()) return bad(checked.fault);

  LoadedParameters version;
  std::array<bool, app::kParameterList.size()> seen{};
  while (!checked.lines.empty()) read_line(next_line(checked.lines), where, version, seen);
  note_missing(seen, where, version);
  renew_defaults(seen, where, version);
  if (const auto contradiction = app::contradiction(version.values)) {
    return bad("is inconsistent: " + std::string(*contradiction));
  }
  version.notes.insert(version.notes.begin(), loaded.notes.begin(), loaded.notes.end());
  loaded = std::move(version);
  return Found::kGood;
}

}  // namespace

std::string parameter_text(const app::Parameters& values, std::span<const std::string> unknown) {
  std::string text = std::string(kFirstLine) + '\n';
  for (const app::ParameterInfo& info : app::kParameterList) {
    text += std::string(info.name) + " = " + number_text(values.*info.member) + '\n';
  }
  for (const std::string& line : unknown) text += line + '\n';
  return text + checksum_line(text);
}

LoadedParameters load_parameters(const std::filesystem::path& path) {
  LoadedParameters loaded;
  const Found file = read_version(path, loaded);
  if (file == Found::kGood) {
    loaded.source = ParameterSource::kFile;
    return loaded;
  }
  const auto previous_path = beside(path, ".previous");
  const Found previous = read_version(previous_path, loaded);
  if (file == Found::kAbsent && previous == Found::kAbsent) {
    loaded.must_be_confirmed = true;
    loaded.notes.push_back("no " + path.string() + ": never set up, or lost");
    loaded.notes.emplace_back(kAllDefaults);
    return loaded;
  }
  if (file == Found::kAbsent) loaded.notes.push_back(path.filename().string() + " is missing");
  if (previous == Found::kGood) {
    loaded.source = ParameterSource::kPrevious;
    loaded.must_be_confirmed = true;  // the values lack the operator's last change
    loaded.notes.push_back("parameters loaded from " + previous_path.filename().string());
    return loaded;
  }
  loaded.source = ParameterSource::kDefaults;
  loaded.must_be_confirmed = true;
  loaded.notes.emplace_back(kAllDefaults);
  return loaded;
}

std::optional<std::string> save_parameters(const std::filesystem::path& path,
                                           const app::Parameters& values,
                                           std::span<const std::string> unknown) {
  const std::string text = parameter_text(values, unknown);
  const FileContent old = read_file(path);
  if (old.error == 0 && old.text == text) return std::nullopt;
  // A damaged file must not replace the good previous one that was loaded instead.
  LoadedParameters ignored;
  if (read_version(path, ignored) == Found::kGood) {
    if (auto fault = replace_file(beside(path, ".previous"), old.text)) return fault;
  }
  return replace_file(path, text);
}

}  // namespace flotilla::target
