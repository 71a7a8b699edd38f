// SPDX-License-Identifier: MIT
#include "linux/system/repeating_thread.hpp"

#include <poll.h>
#include <sys/eventfd.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "linux/system/background_thread.hpp"

namespace flotilla::target {
namespace {

FileDescriptor event(const char* whose) {
  FileDescriptor made(::eventfd(0, EFD_CLOEXEC));
  if (!made)
    throw std::system_error(errno, std::generic_category(), std::string("eventfd of ") + whose);
  return made;
}

}  // namespace

RepeatingThread::RepeatingThread(std::chrono::milliseconds every, std::function<void()> work,
                                 const char* whose)
    : every_(every),
      work_(std::move(work)),
      stop_(event(whose)),
      thread_(start_background_thread(&RepeatingThread::run, this, whose)) {}

RepeatingThread::~RepeatingThread() {
  ::eventfd_write(stop_.get(), 1);
  pthread_join(thread_, nullptr);
}

void* RepeatingThread::run(void* self) {
  const auto& thread = *static_cast<RepeatingThread*>(self);
  for (bool stopped = false; !stopped;) {
    thread.work_();
    pollfd stop{thread.stop_.get(), POLLIN, 0};
    stopped = ::poll(&stop, 1, static_cast<int>(thread.every_.count())) > 0;
  }
  thread.work_();
  return nullptr;
}

}  // namespace flotilla::target
