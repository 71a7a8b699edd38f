// SPDX-License-Identifier: MIT
// That the files are JSON and agree with the parameters is tested by test_metadata.py.
#include <doctest/doctest.h>

#include <algorithm>
#include <charconv>
#include <string>
#include <string_view>

#include "app/operator/metadata.hpp"
#include "app/parameters.hpp"

namespace flotilla::app {
namespace {

/// The file that a client opens for "mftp://" and this path.
std::string_view file_at(std::string_view uri) {
  constexpr std::string_view kScheme = "mftp:///";
  REQUIRE(uri.starts_with(kScheme));
  const auto files = metadata_files();
  const auto file = std::ranges::find(files, uri.substr(kScheme.size()), &link::FtpFile::name);
  REQUIRE(file != files.end());
  return file->content;
}

/// Bit by bit, as the polynomial division is written.
std::uint32_t crc_of(std::string_view bytes) {
  std::uint32_t crc = 0;
  for (const char c : bytes) {
    crc ^= static_cast<std::uint8_t>(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? crc >> 1U ^ 0xEDB88320U : crc >> 1U;
  }
  return crc;
}

TEST_CASE("a ground station finds every file at the address and with the checksum it is told") {
  const std::string_view general = file_at(kGeneralUri);
  CHECK(general_crc() == crc_of(general));
  CHECK(kGeneralUri.size() < 100);  // COMPONENT_METADATA has no room for more

  constexpr std::string_view kCrcKey = "\"fileCrc\":", kUri = "mftp:///parameters.json";
  REQUIRE(general.find(kUri) != std::string_view::npos);
  std::string_view number = general.substr(general.find(kCrcKey) + kCrcKey.size());
  number.remove_prefix(number.find_first_not_of(' '));
  std::uint32_t crc = 0;
  std::from_chars(number.data(), number.data() + number.size(), crc);
  CHECK(crc == crc_of(file_at(kUri)));
}

TEST_CASE(
    "every parameter is described once, in order, with its sentence and when it takes effect") {
  const std::string_view text = file_at("mftp:///parameters.json");
  std::size_t at = 0;
  for (const ParameterInfo& info : kParameterList) {
    CAPTURE(std::string(info.name));
    const std::size_t found = text.find("{\"name\":\"" + std::string(info.name) + "\"");
    REQUIRE(found != std::string_view::npos);
    CHECK(found > at);  // in the order of the list
    at = found;
    const std::string_view entry = text.substr(at, text.find("\"category\"", at) - at);
    CHECK(entry.find(info.sentence) != std::string_view::npos);
    const bool restart = info.change == ParameterChange::kRestart;
    CHECK((entry.find("\"rebootRequired\":true") != std::string_view::npos) == restart);
  }
}

}  // namespace
}  // namespace flotilla::app
