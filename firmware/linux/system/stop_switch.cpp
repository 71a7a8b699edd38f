// SPDX-License-Identifier: MIT
#include "linux/system/stop_switch.hpp"

#include <fcntl.h>
#include <linux/gpio.h>
#include <sys/ioctl.h>

#include <cerrno>
#include <cstring>

namespace flotilla::target {

void StopSwitch::reopen() {
  if (chip_.empty()) return;
  request_.reopen([this](FileDescriptor& line) { return open(line); });
}

int StopSwitch::open(FileDescriptor& line) const {
  const FileDescriptor chip(::open(("/dev/" + chip_).c_str(), O_RDONLY | O_CLOEXEC));
  if (!chip) return errno;
  gpio_v2_line_request request{};
  request.offsets[0] = line_;
  request.num_lines = 1;
  request.config.flags = GPIO_V2_LINE_FLAG_INPUT | GPIO_V2_LINE_FLAG_BIAS_PULL_UP;
  std::strcpy(request.consumer, "flotillad stop");
  if (::ioctl(chip.get(), GPIO_V2_GET_LINE_IOCTL, &request) != 0) return errno;
  line = FileDescriptor(request.fd);
  return 0;
}

bool StopSwitch::pressed() {
  if (chip_.empty()) return false;
  gpio_v2_line_values values{.bits = 0, .mask = 1};
  request_.take();
  if (request_ && ::ioctl(request_->get(), GPIO_V2_LINE_GET_VALUES_IOCTL, &values) == 0) {
    return values.bits != 0;
  }
  request_.give_up();
  return true;
}

}  // namespace flotilla::target
