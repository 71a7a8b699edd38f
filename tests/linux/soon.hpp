// SPDX-License-Identifier: MIT
#pragma once

#include <poll.h>

namespace flotilla::target {

/// Waits until `done`, to give another thread time; false after 10 s.
template <class Done>
bool soon(Done done) {
  for (int i = 0; i < 1000; ++i) {
    if (done()) return true;
    ::poll(nullptr, 0, 10);
  }
  return false;
}

}  // namespace flotilla::target
