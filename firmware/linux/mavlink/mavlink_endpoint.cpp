// SPDX-License-Identifier: MIT
#include "linux/mavlink/mavlink_endpoint.hpp"

#include <charconv>
#include <stdexcept>
#include <string>

#include "linux/mavlink/endpoint_address.hpp"
#include "linux/mavlink/serial_endpoint.hpp"
#include "linux/mavlink/udp_endpoint.hpp"

namespace flotilla::target {
namespace {

constexpr const char* kLoopback = "127.0.0.1";

/// "a:b:c"; the middle part may contain colons. "udpin:c" stays on this machine.
EndpointAddress split(std::string_view address) {
  const std::size_t first = address.find(':'), last = address.rfind(':');
  const std::string whole(address);
  if (first == last && address.starts_with("udpin:")) {
    return {whole, "udpin", kLoopback, whole.substr(first + 1)};
  }
  if (first == std::string_view::npos || first == last) {
    refuse(address,
           "must be udpin:[HOST:]PORT, udpout:HOST:PORT, udpbcast:HOST:PORT or serial:DEVICE:BAUD");
  }
  return {whole, whole.substr(0, first), whole.substr(first + 1, last - first - 1),
          whole.substr(last + 1)};
}

/// Serial, or a kind of UDP; refuses other kinds.
bool is_serial(const EndpointAddress& parts) {
  if (parts.scheme == "serial") return true;
  if (parts.scheme != "udpin" && parts.scheme != "udpout" && parts.scheme != "udpbcast") {
    refuse(parts.whole, "unknown kind \"" + parts.scheme + "\": udpin, udpout, udpbcast or serial");
  }
  return false;
}

}  // namespace

void refuse(std::string_view address, const std::string& why) {
  throw std::runtime_error("MAVLink link \"" + std::string(address) + "\": " + why);
}

unsigned number_of(const EndpointAddress& address, unsigned greatest) {
  const std::string& text = address.number;
  unsigned value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || value == 0 || value > greatest) {
    refuse(address.whole, "\"" + text + "\" is not a number from 1 to " + std::to_string(greatest));
  }
  return value;
}

void require_mavlink_address(std::string_view address) {
  const EndpointAddress parts = split(address);
  if (is_serial(parts)) {
    speed_of(parts);
  } else {
    socket_address_of(parts);
  }
}

std::unique_ptr<MavlinkEndpoint> open_mavlink_endpoint(std::string_view address) {
  const EndpointAddress parts = split(address);
  if (is_serial(parts)) return std::make_unique<SerialEndpoint>(parts);
  return std::make_unique<UdpEndpoint>(parts);
}

}  // namespace flotilla::target
