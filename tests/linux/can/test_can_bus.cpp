// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>
#include <linux/can.h>
#include <sys/socket.h>

#include <array>
#include <stdexcept>
#include <utility>

#include "linux/can/can_bus.hpp"
#include "linux/system/file_descriptor.hpp"

namespace flotilla::target {
namespace {

std::string refusal(std::string_view address, std::uint8_t node = 20) {
  try {
    open_can_bus(address, node);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "opened";
}

TEST_CASE("an address that names no bus is refused, and the refusal says what is wrong with it") {
  const auto says = [](std::string_view address, const std::string& why) {
    CHECK(refusal(address) == "CAN bus \"" + std::string(address) + "\": " + why);
  };
  for (const char* address : {"", "can0", "slcan:can0", "socketcan", "MCAST:0"}) {
    CAPTURE(address);
    CHECK(refusal(address).find("CAN bus \"") == 0);
  }
  says("can0", "must be socketcan:INTERFACE or mcast:N[:ADDRESS]");
  says("mcast", "\"\" is not a bus number from 0 to 9");
  says("mcast:", "\"\" is not a bus number from 0 to 9");
  says("mcast:10", "\"10\" is not a bus number from 0 to 9");
  says("mcast:-1", "\"-1\" is not a bus number from 0 to 9");
  says("mcast:x:127.0.0.1", "\"x\" is not a bus number from 0 to 9");
  says("mcast:0:", "\"\" is not an IPv4 address");
  says("mcast:0:eth0", "\"eth0\" is not an IPv4 address");
  says("mcast:0:127.1", "\"127.1\" is not an IPv4 address");
  says("mcast:0:127.0.0.1:5", "\"127.0.0.1:5\" is not an IPv4 address");
  says("mcast:0:0.0.0.0", "0.0.0.0 is not an interface address");
  says("mcast:0:239.65.82.0", "239.65.82.0 is not an interface address");
  says("mcast:0:255.255.255.255", "255.255.255.255 is not an interface address");
  says("socketcan:", "\"\" is not an interface name");
  says("socketcan:a/b", "\"a/b\" is not an interface name");
  says("socketcan:sixteen_letters_", "\"sixteen_letters_\" is not an interface name");
}

TEST_CASE("a node id that no DroneCAN node may have is refused") {
  for (const std::uint8_t node : std::array<std::uint8_t, 3>{0, 128, 255}) {
    CHECK(refusal("mcast:9", node) ==
          "CAN bus \"mcast:9\": " + std::to_string(node) + " is not a node id from 1 to 127");
  }
  CHECK(refusal("mcast:9", 1) == "opened");
  CHECK(refusal("mcast:9", 127) == "opened");
}

TEST_CASE("a missing address is reported, and tried again") {
  const auto bus = open_can_bus("mcast:0:203.0.113.77", 20);
  bus->reopen();
  bus->maintain();
  CHECK_FALSE(bus->usable());
  CHECK(bus->descriptor() == -1);
  CHECK(bus->fault() == "no interface of this machine has that address");
}

TEST_CASE("a kernel without CAN is reported as the cause") {
  const FileDescriptor probe(::socket(PF_CAN, SOCK_RAW, CAN_RAW));
  if (probe) {
    MESSAGE("this kernel has AF_CAN: nothing to see here");
    return;
  }
  CHECK(open_can_bus("socketcan:can0", 20)->fault().starts_with("this kernel has no AF_CAN"));
}

TEST_CASE("frames are grouped into transfers by their tail bytes") {
  const auto frame = [](std::uint8_t tail) { return link::CanFrame{0x10040A15, 2, {0x55, tail}}; };
  const link::CanFrame empty{1, 0, {}};
  const std::array frames{frame(0xC0), frame(0x80), frame(0x20), frame(0x40),
                          empty,       frame(0x80), frame(0x20)};
  std::span<const link::CanFrame> rest(frames);
  for (const std::size_t expected : {1U, 3U, 1U, 2U}) {  // the last one was never finished
    const auto transfer = first_transfer(rest);
    CHECK(transfer.data() == rest.data());
    CHECK(transfer.size() == expected);
    rest = rest.subspan(transfer.size());
  }
  CHECK(rest.empty());
}

}  // namespace
}  // namespace flotilla::target
