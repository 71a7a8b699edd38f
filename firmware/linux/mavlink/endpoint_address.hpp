// SPDX-License-Identifier: MIT
// The parts of a link's address, and the error for a mistake in one.
#pragma once

#include <netinet/in.h>
#include <termios.h>

#include <string>
#include <string_view>

namespace flotilla::target {

struct EndpointAddress {
  std::string whole, scheme, place, number;
};

/// Throws std::runtime_error that names the address and `why` it is wrong.
[[noreturn]] void refuse(std::string_view address, const std::string& why);

/// The last part as a number from 1 to `greatest`, else refuses.
unsigned number_of(const EndpointAddress& address, unsigned greatest);

/// The address of a socket, or the code of a serial port's baud rate; refuses a malformed address.
sockaddr_in socket_address_of(const EndpointAddress& address);
speed_t speed_of(const EndpointAddress& address);

}  // namespace flotilla::target
