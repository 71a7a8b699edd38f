// SPDX-License-Identifier: MIT
#pragma once

namespace flotilla::target {

/// Ends the emulator, with status 0 or 1.
[[noreturn]] void leave(bool well);

}  // namespace flotilla::target
