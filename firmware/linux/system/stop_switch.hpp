// SPDX-License-Identifier: MIT
// A stop switch on a GPIO line, through the kernel's interface, because libgpiod's differs between
// its releases.
#pragma once

#include <string>
#include <utility>

#include "linux/system/file_descriptor.hpp"
#include "linux/system/reopened.hpp"

namespace flotilla::target {

/// The switch is normally closed, between the line and ground, with the chip's pull-up (or a
/// resistor if the chip has none): pressing it or cutting its wire makes the line high. A line that
/// cannot be read counts as pressed.
class StopSwitch {
 public:
  /// A line of /dev/CHIP; an empty chip: no switch.
  StopSwitch(std::string chip, unsigned line) : chip_(std::move(chip)), line_(line) {}

  /// Opens the line if it is closed. Call it from another thread than the loop's.
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
