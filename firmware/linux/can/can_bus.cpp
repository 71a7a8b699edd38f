// SPDX-License-Identifier: MIT
#include "linux/can/can_bus.hpp"

#include <arpa/inet.h>
#include <net/if.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>

#include "linux/can/mcast_bus.hpp"
#include "linux/can/socketcan_bus.hpp"

namespace flotilla::target {
namespace {

constexpr std::uint8_t kEndOfTransfer = 0x40, kGreatestNode = 127;

[[noreturn]] void refuse(std::string_view address, const std::string& why) {
  throw std::runtime_error("CAN bus \"" + std::string(address) + "\": " + why);
}

/// The kernel's rule for names of interfaces.
bool is_interface_name(std::string_view name) {
  return !name.empty() && name.size() < IFNAMSIZ && name != "." && name != ".." &&
         name.find_first_of("/: \t\n") == std::string_view::npos;
}

in_addr interface_of(std::string_view address, const std::string& text) {
  in_addr interface{};
  if (inet_pton(AF_INET, text.c_str(), &interface) != 1) {
    refuse(address, "\"" + text + "\" is not an IPv4 address");
  }
  const std::uint32_t number = ntohl(interface.s_addr);
  if (number == INADDR_ANY || number == INADDR_BROADCAST || IN_MULTICAST(number)) {
    refuse(address, text + " is not an interface address");
  }
  return interface;
}

struct Multicast {
  unsigned bus;
  std::optional<in_addr> interface;
};

/// The parts of `mcast:N[:ADDRESS]`, or the name of a SocketCAN interface.
std::variant<Multicast, std::string> parts_of(std::string_view address) {
  const std::size_t colon = std::min(address.find(':'), address.size());
  const std::string_view scheme = address.substr(0, colon);
  const std::string_view rest = address.substr(std::min(colon + 1, address.size()));
  if (scheme == "mcast") {
    const std::string_view number = rest.substr(0, rest.find(':'));
    if (number.size() != 1 || number[0] < '0' || number[0] > '9') {
      refuse(address, "\"" + std::string(number) + "\" is not a bus number from 0 to 9");
    }
    const unsigned bus = static_cast<unsigned>(number[0] - '0');
    if (rest.size() == 1) return Multicast{bus, std::nullopt};
    return Multicast{bus, interface_of(address, std::string(rest.substr(2)))};
  }
  if (scheme != "socketcan") refuse(address, "must be socketcan:INTERFACE or mcast:N[:ADDRESS]");
  if (!is_interface_name(rest)) {
    refuse(address, "\"" + std::string(rest) + "\" is not an interface name");
  }
  return std::string(rest);
}

}  // namespace

void CanBus::count_overflows(msghdr& message) {
  for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c)) {
    if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SO_RXQ_OVFL) continue;
    std::uint32_t overflows = 0;
    std::memcpy(&overflows, CMSG_DATA(c), sizeof overflows);
    counters_.receive_overflows += overflows - overflows_seen_;
    overflows_seen_ = overflows;
  }
}

std::span<const link::CanFrame> first_transfer(std::span<const link::CanFrame> frames) {
  const auto last = std::ranges::find_if(frames, [](const link::CanFrame& frame) {
    return frame.size == 0 || (frame.data[frame.size - 1U] & kEndOfTransfer) != 0;
  });
  return last == frames.end() ? frames : std::span(frames.begin(), last + 1);
}

std::unique_ptr<CanBus> open_can_bus(std::string_view address, std::uint8_t node) {
  if (node == 0 || node > kGreatestNode) {
    refuse(address, std::to_string(node) + " is not a node id from 1 to 127");
  }
  const auto parts = parts_of(address);
  if (const auto* multicast = std::get_if<Multicast>(&parts)) {
    return std::make_unique<McastBus>(multicast->bus, multicast->interface);
  }
  return std::make_unique<SocketCanBus>(std::get<std::string>(parts), node);
}

void require_can_address(std::string_view address) { parts_of(address); }

}  // namespace flotilla::target
