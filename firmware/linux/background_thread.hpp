// SPDX-License-Identifier: MIT
// Threads for what may wait for the disk, beside the control loop.
#pragma once

#include <pthread.h>

namespace flotilla::target {

/// Starts `run(self)`; to be joined. The thread takes no signals and no real-time priority, and has
/// a stack small enough to be locked in memory. Throws std::system_error, which says whose it is.
pthread_t start_background_thread(void* (*run)(void*), void* self, const char* whose);

}  // namespace flotilla::target
