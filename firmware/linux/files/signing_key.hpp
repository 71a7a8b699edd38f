// SPDX-License-Identifier: MIT
// MAVLink 2's signing key in a file: 32 bytes, or 64 hexadecimal digits with an optional newline.
#pragma once

#include <filesystem>

#include "link/mavlink/signing.hpp"

namespace flotilla::target {

/// Throws std::runtime_error, also if group or others may use the file, or another user owns it
/// (except root).
link::SigningKey read_signing_key(const std::filesystem::path& path);

}  // namespace flotilla::target
