// SPDX-License-Identifier: MIT
// A stop switch on a GPIO line, by the kernel's interface: libgpiod's differs between the releases of
// distributions.
#pragma once

#include <string>

#include "linux/system/file_descriptor.hpp"

namespace flotilla::target {

/// Normally closed, between the line and ground, with the chip's pull-up: when it is pressed, or its
/// wire is cut, the line is high. A line that cannot be read counts as pressed.
class StopSwitch {
 public:
  /// Of /dev/CHIP; an empty chip: no switch.
  StopSwitch(std::string chip, unsigned line) : chip_(std::move(chip)), line_(line) {}

  /// Opens it where it is closed; 0 or errno.
  int open();

  bool pressed();

 private:
  std::string chip_;
  unsigned line_;
  FileDescriptor request_;
};

}  // namespace flotilla::target
