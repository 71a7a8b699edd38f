// SPDX-License-Identifier: MIT
// What the boat tells ground stations about its parameters: MAVLink component metadata, as the
// files that its FTP server offers. They are made of parameters.def when the firmware is compiled.
// Source: mavlink.io, services, Component Metadata; version 1, which QGroundControl insists on.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "link/mavlink/ftp_server.hpp"

namespace flotilla::app {

/// Where the description of all metadata is, for COMPONENT_METADATA, and its CRC.
constexpr std::string_view kGeneralUri = "mftp:///general.json";
std::uint32_t general_crc();

std::span<const link::FtpFile> metadata_files();

}  // namespace flotilla::app
