// SPDX-License-Identifier: MIT
// Preloaded under qemu-user, which lacks some of Linux's socket options: accepts them without
// effect. A bus that is alone in its network does not need them.
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>

extern "C" int setsockopt(int socket, int level, int name, const void* value, socklen_t size) {
  const bool joins = level == IPPROTO_IP && name == IP_ADD_MEMBERSHIP;
  if (joins && size == sizeof(ip_mreqn)) size = sizeof(ip_mreq);
  const long done = ::syscall(SYS_setsockopt, socket, level, name, value, size);
  return done != 0 && errno == ENOPROTOOPT ? 0 : static_cast<int>(done);
}
