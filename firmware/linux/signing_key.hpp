// SPDX-License-Identifier: MIT
// The key of MAVLink 2 signing as a file: 32 bytes, or 64 hexadecimal digits and perhaps a newline.
#pragma once

#include <filesystem>

#include "link/mavlink/signing.hpp"

namespace flotilla::target {

/// Throws std::runtime_error, also where others than its owner may read or write the file, or it
/// belongs to neither us nor root.
link::SigningKey read_signing_key(const std::filesystem::path& path);

}  // namespace flotilla::target
