// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>
#include <fcntl.h>
#include <stdlib.h>

#include <array>
#include <cerrno>
#include <filesystem>
#include <string>

#include "linux/mavlink/mavlink_endpoint.hpp"
#include "linux/scratch.hpp"
#include "linux/system/file_descriptor.hpp"

namespace flotilla::target {
namespace {

TEST_CASE("the control loop's calls never open a serial port: another thread's reopen() does") {
  const Scratch folder;
  const auto device = folder / "ttyUSB0";
  const auto link = open_mavlink_endpoint("serial:" + device.string() + ":57600");
  CHECK(link->descriptor() == -1);
  CHECK(link->error() == ENOENT);

  const FileDescriptor cable(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC));
  REQUIRE(::grantpt(cable.get()) == 0);
  REQUIRE(::unlockpt(cable.get()) == 0);
  std::filesystem::create_symlink(::ptsname(cable.get()), device);
  std::array<std::uint8_t, 8> bytes{1, 2, 3};
  for (int i = 0; i < 3; ++i) {
    link->maintain(i);
    link->send(bytes);
    CHECK(link->receive(bytes) == 0);
    CHECK(link->descriptor() == -1);
  }
  link->reopen();
  CHECK(link->descriptor() == -1);  // the loop's from its next turn on
  link->maintain(3);
  CHECK(link->descriptor() >= 0);
  CHECK(link->error() == 0);
}

}  // namespace
}  // namespace flotilla::target
