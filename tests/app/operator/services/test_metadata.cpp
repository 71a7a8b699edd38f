// SPDX-License-Identifier: MIT
// That the files are JSON and agree with the parameters is tested by test_metadata.py.
#include <doctest/doctest.h>

#include <algorithm>
#include <charconv>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "app/operator/services/metadata.hpp"
#include "app/parameters.hpp"

namespace flotilla::app {
namespace {

/// CRC bit by bit, by polynomial division.
std::uint32_t crc_of(std::string_view bytes) {
  std::uint32_t crc = 0;
  for (const char c : bytes) {
    crc ^= static_cast<std::uint8_t>(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? crc >> 1U ^ 0xEDB88320U : crc >> 1U;
  }
  return crc;
}

/// The file that a client opens for "mftp://" and this path.
std::string file_at(std::string_view uri) {
  constexpr std::string_view kScheme = "mftp:///";
  REQUIRE(uri.starts_with(kScheme));
  const auto files = metadata_files();
  const auto file = std::ranges::find(files, uri.substr(kScheme.size()), &link::FtpFile::name);
  REQUIRE(file != files.end());
  std::vector<std::uint8_t> bytes(file->content.size());
  REQUIRE(file->content.read(0, bytes) == bytes.size());
  CHECK(file->content.crc() == crc_of({reinterpret_cast<const char*>(bytes.data()), bytes.size()}));
  return {bytes.begin(), bytes.end()};
}

TEST_CASE("every file is at the address and has the checksum that a ground station receives") {
  const std::string general = file_at(kGeneralUri);
  CHECK(general_crc() == crc_of(general));
  CHECK(kGeneralUri.size() < 100);  // COMPONENT_METADATA has no room for more

  constexpr std::string_view kCrcKey = "\"fileCrc\":", kUri = "mftp:///parameters.json";
  REQUIRE(general.find(kUri) != std::string_view::npos);
  std::string_view number =
      std::string_view(general).substr(general.find(kCrcKey) + kCrcKey.size());
  number.remove_prefix(number.find_first_not_of(' '));
  std::uint32_t crc = 0;
  std::from_chars(number.data(), number.data() + number.size(), crc);
  CHECK(crc == crc_of(file_at(kUri)));
}

TEST_CASE(
    "every parameter is described once, in order, with its sentence and when it takes effect") {
  const std::string file = file_at("mftp:///parameters.json");
  const std::string_view text = file;
  std::size_t at = 0;
  for (std::size_t i = 0; i < kParameterList.size(); ++i) {
    const ParameterInfo& info = kParameterList[i];
    CAPTURE(std::string(info.name));
    const std::size_t found = text.find("{\"name\":\"" + std::string(info.name) + "\"");
    REQUIRE(found != std::string_view::npos);
    CHECK(found > at);  // in the order of the list
    at = found;
    const std::string_view entry = text.substr(at, text.find("\"category\"", at) - at);
    CHECK(entry.find(kParameterTexts[i].sentence) != std::string_view::npos);
    const bool restart = info.change == ParameterChange::kRestart;
    CHECK((entry.find("\"rebootRequired\":true") != std::string_view::npos) == restart);
  }
}

TEST_CASE("a packed file reads the same from any offset and in pieces of any size") {
  const std::string text = file_at("mftp:///parameters.json");
  const auto files = metadata_files();
  const auto file = std::ranges::find(files, "parameters.json", &link::FtpFile::name);
  REQUIRE(file != files.end());
  std::mt19937 random(7);
  INFO("seed 7");
  for (int i = 0; i < 20'000; ++i) {
    const std::size_t at = random() % (text.size() + 300);
    std::vector<std::uint8_t> bytes(random() % 700, 0xEE);
    const std::size_t taken = file->content.read(at, bytes);
    const std::string rest = at < text.size() ? text.substr(at, bytes.size()) : "";
    REQUIRE(taken == rest.size());
    REQUIRE(std::equal(rest.begin(), rest.end(), bytes.begin(),
                       [](char c, std::uint8_t b) { return static_cast<std::uint8_t>(c) == b; }));
    REQUIRE(std::all_of(bytes.begin() + static_cast<std::ptrdiff_t>(taken), bytes.end(),
                        [](std::uint8_t b) { return b == 0xEE; }));
  }
}

}  // namespace
}  // namespace flotilla::app
