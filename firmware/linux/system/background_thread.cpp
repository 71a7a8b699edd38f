// SPDX-License-Identifier: MIT
#include "linux/system/background_thread.hpp"

#include <csignal>
#include <cstddef>
#include <string>
#include <system_error>

namespace flotilla::target {
namespace {

constexpr std::size_t kStackBytes = 256U << 10U;

}  // namespace

pthread_t start_background_thread(void* (*run)(void*), void* self, const char* whose) {
  pthread_attr_t attributes;
  sigset_t signals;
  const sched_param normal{};
  sigfillset(&signals);
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, kStackBytes);
  pthread_attr_setsigmask_np(&attributes, &signals);
  pthread_attr_setinheritsched(&attributes, PTHREAD_EXPLICIT_SCHED);
  pthread_attr_setschedpolicy(&attributes, SCHED_OTHER);
  pthread_attr_setschedparam(&attributes, &normal);
  pthread_t thread{};
  const int error = pthread_create(&thread, &attributes, run, self);
  pthread_attr_destroy(&attributes);
  if (error != 0) {
    throw std::system_error(error, std::generic_category(), std::string("thread of ") + whose);
  }
  return thread;
}

}  // namespace flotilla::target
