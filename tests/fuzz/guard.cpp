// SPDX-License-Identifier: MIT
#include "fuzz/guard.hpp"

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <utility>

// From sanitizer/allocator_interface.h; without sanitizers nothing is counted.
extern "C" __attribute__((weak)) int __sanitizer_install_malloc_and_free_hooks(
    void (*malloc_hook)(const volatile void*, std::size_t),
    void (*free_hook)(const volatile void*));

namespace flotilla::fuzz {
namespace {

constexpr std::int64_t kSlowest_ns = 100'000'000;

thread_local bool guarded = false;  // libFuzzer has other threads

/// Aborts at once, so that the stack shows the caller that requested memory.
void note_allocation(const volatile void*, std::size_t) {
  if (!std::exchange(guarded, false)) return;
  require(false, "the boat uses no heap after construction");
}

[[maybe_unused]] const int kHooked =
    __sanitizer_install_malloc_and_free_hooks == nullptr
        ? 0
        : __sanitizer_install_malloc_and_free_hooks(note_allocation, [](const volatile void*) {});

std::int64_t thread_time_ns() {
  std::timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

}  // namespace

void require(bool holds, const char* sentence) {
  if (holds) return;
  std::fprintf(stderr, "ORACLE: %s\n", sentence);
  std::abort();
}

Guard::Guard() : begin_ns_(thread_time_ns()) { guarded = true; }

Guard::~Guard() {
  guarded = false;
  require(thread_time_ns() - begin_ns_ < kSlowest_ns, "a call's time is bounded");
}

}  // namespace flotilla::fuzz
