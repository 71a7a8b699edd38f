// SPDX-License-Identifier: MIT
// The libraries' hooks for fatal errors. Their own versions would call printf, which needs a heap.
#include "cortex_m/platform.hpp"
#include "cortex_m/semihosting.hpp"

namespace {

[[noreturn]] void stop(const char* why) {
  flotilla::target::print(why);
  flotilla::target::leave(false);
}

}  // namespace

extern "C" [[noreturn]] void abort() { stop("abort\n"); }

extern "C" [[noreturn]] void __assert_func(const char*, int, const char*, const char*) {
  stop("assertion\n");
}

namespace std {

[[noreturn]] void __throw_out_of_range_fmt(const char*, ...) { stop("out of range\n"); }

}  // namespace std
