// SPDX-License-Identifier: MIT
// Threads for work that may wait for the disk, beside the control loop.
#pragma once

#include <pthread.h>

namespace flotilla::target {

/// Starts `run(self)`; the caller joins it. The thread has no signals, no real-time priority, and a
/// stack small enough to be locked in memory. Throws std::system_error that names `whose`.
pthread_t start_background_thread(void* (*run)(void*), void* self, const char* whose);

}  // namespace flotilla::target
