// SPDX-License-Identifier: MIT
#include "app/operator/services/metadata.hpp"

#include <array>

#include "metadata_json.hpp"

namespace flotilla::app {
namespace {

constexpr std::array kFiles{link::FtpFile{"general.json", kGeneralJson},
                            link::FtpFile{"parameters.json", link::PackedText(kParameters)}};

}  // namespace

std::uint32_t general_crc() { return kFiles[0].content.crc(); }

std::span<const link::FtpFile> metadata_files() { return kFiles; }

}  // namespace flotilla::app
