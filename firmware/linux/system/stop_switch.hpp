// SPDX-License-Identifier: MIT
// A stop switch on a GPIO line, by the kernel's interface: libgpiod's differs between the releases of
// distributions.
#pragma once

#include <string>
#include <utility>

#include "linux/system/file_descriptor.hpp"
#include "linux/system/reopened.hpp"

namespace flotilla::target {

/// Normally closed, between the line and ground, with the chip's pull-up (or a resistor where the chip
/// has none): when it is pressed, or its wire is cut, the line is high. A line that cannot be read
/// counts as pressed.
class StopSwitch {
 public:
  /// Of /dev/CHIP; an empty chip: no switch.
  StopSwitch(std::string chip, unsigned line) : chip_(std::move(chip)), line_(line) {}

  /// For another thread than the loop's: opens it where it is closed.
  void reopen();

  bool pressed();

  /// errno of the last attempt to open it.
  int error() const { return request_.error(); }

 private:
  int open(FileDescriptor& line) const;

  std::string chip_;
  unsigned line_;
  Reopened<FileDescriptor> request_;
};

}  // namespace flotilla::target
