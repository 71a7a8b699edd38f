// SPDX-License-Identifier: MIT
// Files and option texts that flotillad reads: parameters, node ids, the signing time, addresses.
// The first byte chooses; what was read must be usable, and survive being saved. boat.toml is left
// out: toml++ 3.3 runs into its own TOML_UNREACHABLE at any bare letter from U+00A1 to U+0499.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "fuzz/stream.hpp"
#include "fuzz/watched_boat.hpp"
#include "linux/config/config_values.hpp"
#include "linux/files/durable_file.hpp"
#include "linux/files/node_table.hpp"
#include "linux/files/parameter_file.hpp"
#include "linux/files/signing_time.hpp"

namespace flotilla::fuzz {
namespace {

using target::ParameterSource;

/// A directory for this process alone, in memory if possible.
struct Directory {
  std::filesystem::path path;
  Directory() {
    const std::filesystem::path memory = "/dev/shm";
    const auto base =
        std::filesystem::is_directory(memory) ? memory : std::filesystem::temp_directory_path();
    path = base / ("flotilla-fuzz-" + std::to_string(::getpid()));
    std::filesystem::create_directories(path);
  }
  ~Directory() { std::filesystem::remove_all(path); }
};

const std::filesystem::path& directory() {
  static const Directory kDirectory;
  return kDirectory.path;
}

void write(const std::filesystem::path& path, std::string_view text) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << text;
}

std::string rest(Stream& in) {
  const auto bytes = in.take(SIZE_MAX);
  return {bytes.begin(), bytes.end()};
}

void check_usable(const app::Parameters& values) {
  for (const app::ParameterInfo& info : app::kParameterList) {
    require(app::is_valid(info, values.*info.member), "every loaded value is valid");
  }
  require(!app::contradiction(values), "loaded values do not contradict each other");
  WatchedBoat<float> boat({values});
  for (std::int64_t now_us = 0; now_us < 30'000; now_us += 10'000) boat.tick(now_us);
}

bool equal(const app::Parameters& a, const app::Parameters& b) {
  for (const app::ParameterInfo& info : app::kParameterList) {
    if (a.*info.member != b.*info.member) return false;
  }
  return true;
}

/// kind bits: 1 the checksum is right, 2 the title is, 4 a version before is there, 8 the text is the
/// version before.
void parameters(Stream& in, unsigned kind) {
  const auto path = directory() / "parameters.txt";
  const auto previous = target::beside(path, ".previous");
  std::string text = (kind & 2U) != 0 ? "flotilla-parameters 1\n" : "";
  text += rest(in);
  if ((kind & 1U) != 0) text += target::checksum_line(text);
  std::filesystem::remove(path);
  std::filesystem::remove(previous);
  if ((kind & 4U) != 0) write(previous, target::parameter_text({}, {}));
  write((kind & 8U) != 0 ? previous : path, text);

  const target::LoadedParameters loaded = target::load_parameters(path);
  check_usable(loaded.values);
  const bool defaults =
      loaded.source == ParameterSource::kDefaults || loaded.source == ParameterSource::kFirstStart;
  require(!defaults || loaded.must_be_confirmed, "defaults must be confirmed");
  require(loaded.source != ParameterSource::kPrevious || (kind & 12U) != 0,
          "the version before is taken where there is one");
  require(!target::save_parameters(path, loaded.values, loaded.unknown), "a disk takes them");
  const target::LoadedParameters again = target::load_parameters(path);
  require(again.source == ParameterSource::kFile, "what was saved is whole");
  require(!again.must_be_confirmed, "what was saved needs no confirmation");
  require(equal(again.values, loaded.values), "what was saved reads back the same");
  require(again.unknown == loaded.unknown, "unknown lines survive being saved");
}

template <class F>
void refuses_politely(F read) {
  try {
    read();
  } catch (const target::ValueError&) {
  }
}

void options(Stream& in) {
  const std::string text = rest(in);
  refuses_politely([&] { target::can_address(text); });
  refuses_politely([&] { target::mavlink_link(text); });
  refuses_politely([&] {
    const auto equals = text.find('=');
    if (equals == std::string::npos) return;
    const std::string_view value = std::string_view(text).substr(equals + 1);
    target::parameter_value(text.substr(0, equals), target::number<double>(value), value);
  });
}

void node_ids(Stream& in) {
  const auto path = directory() / "node_ids.txt";
  write(path, rest(in));
  link::NodeIdServer server(20), again(20);
  target::NodeTable(path).load(server);
  {
    target::NodeTable table(path);
    while (!table.save(server)) continue;
    // Its destructor waits for the disk.
  }
  target::NodeTable(path).load(again);
  require(server.table().size() == again.table().size(), "the table reads back as long");
}

void signing_time(Stream& in, bool checksum) {
  const auto path = directory() / "signing_time.txt";
  std::string text = "flotilla-signing-time 1 " + rest(in);
  if (checksum) text += target::checksum_line(text);
  write(path, text);
  const auto loaded = target::load_signing_time(path);
  require(loaded.timestamp == 0 || loaded.note.empty(), "a time that is used needs no note");
}

}  // namespace
}  // namespace flotilla::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace flotilla::fuzz;
  Stream in(std::span(data, size));
  const unsigned kind = in.byte();
  switch (kind >> 4U & 7U) {
    case 0:
    case 1:
    case 2:
    case 3:
      parameters(in, kind);
      break;
    case 4:
    case 5:
      options(in);
      break;
    case 6:
      node_ids(in);
      break;
    default:
      signing_time(in, (kind & 1U) != 0);
  }
  return 0;
}
