// SPDX-License-Identifier: MIT
// A thread for what the control loop must not wait for.
#pragma once

#include <pthread.h>

namespace flotilla::target {

/// It takes no signals and no real-time priority, and has a stack small enough to be locked in
/// memory. Throws std::system_error where none can be made.
pthread_t start_background_thread(void* (*run)(void*), void* argument);

}  // namespace flotilla::target
