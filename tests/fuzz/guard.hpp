// SPDX-License-Identifier: MIT
// What a fuzz target demands beside "no sanitizer complains".
#pragma once

#include <cstddef>
#include <cstdint>

namespace flotilla::fuzz {

/// Ends the run, with that sentence, unless it holds.
void require(bool holds, const char* sentence);

/// Around one call into the boat, for which it demands: no heap, and a bounded time of this thread's
/// own (a hundred times what the slowest call takes with all sanitizers).
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
