// SPDX-License-Identifier: MIT
// The boat's parameter metadata for ground stations: MAVLink component metadata, as files of its
// FTP server, generated from parameters.def at compile time. Source: mavlink.io, services,
// Component Metadata; version 1, which QGroundControl requires.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "link/mavlink/ftp_server.hpp"

namespace flotilla::app {

/// URI and CRC of the general metadata file, for COMPONENT_METADATA.
constexpr std::string_view kGeneralUri = "mftp:///general.json";
std::uint32_t general_crc();

std::span<const link::FtpFile> metadata_files();

}  // namespace flotilla::app
