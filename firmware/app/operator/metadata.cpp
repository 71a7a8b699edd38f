// SPDX-License-Identifier: MIT
#include "app/operator/metadata.hpp"

#include <array>

#include "app/parameters.hpp"
#include "link/mavlink/crc32.hpp"
#include "metadata_json.hpp"

namespace flotilla::app {
namespace {

constexpr std::array kFiles{link::FtpFile{"general.json", kGeneralJson},
                            link::FtpFile{"parameters.json", kParametersJson}};

}  // namespace

std::uint32_t general_crc() {
  constexpr std::uint32_t kCrc = link::crc32(link::kMavlinkCrc32Start, kGeneralJson);
  return kCrc;
}

std::span<const link::FtpFile> metadata_files() { return kFiles; }

}  // namespace flotilla::app
