// SPDX-License-Identifier: MIT
// Demands of a fuzz target in addition to "no sanitizer complains".
#pragma once

#include <cstddef>
#include <cstdint>

namespace flotilla::fuzz {

/// Ends the run, with that sentence, unless it holds.
void require(bool holds, const char* sentence);

/// Guards one call into the boat. The call must use no heap, and only a bounded time of its own
/// thread: a hundred times that of the slowest call with all sanitizers.
class Guard {
 public:
  Guard();
  Guard(const Guard&) = delete;
  Guard& operator=(const Guard&) = delete;
  ~Guard();

 private:
  std::int64_t begin_ns_;
};

}  // namespace flotilla::fuzz
