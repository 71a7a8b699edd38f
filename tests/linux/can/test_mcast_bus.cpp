// SPDX-License-Identifier: MIT
#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <fcntl.h>
#include <net/if.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "linux/can/mcast_bus.hpp"

namespace flotilla::target {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr int kPatience_ms = 2000;

bool readable(int descriptor, int timeout_ms = kPatience_ms) {
  pollfd desired{descriptor, POLLIN, 0};
  return ::poll(&desired, 1, timeout_ms) == 1;
}

bool next(CanBus& bus, link::CanFrame& frame) {
  while (!bus.receive(frame)) {
    if (!readable(bus.descriptor())) return false;
  }
  return true;
}

/// Another run of these tests on this machine would send on the same buses.
struct QuietBuses {
  FileDescriptor lock{::open("/tmp/flotilla-mcast-tests.lock", O_CREAT | O_RDWR | O_CLOEXEC, 0666)};
  QuietBuses() { ::flock(lock.get(), LOCK_EX); }
};

/// Another program's plain UDP sockets on the bus.
class Wire {
 public:
  struct Datagram {
    Bytes bytes;
    int time_to_live = -1;
    std::string from, interface;
  };

  explicit Wire(unsigned bus) {
    group_.sin_family = AF_INET;
    group_.sin_port = htons(57732);
    inet_pton(AF_INET, ("239.65.82." + std::to_string(bus)).c_str(), &group_.sin_addr);
    const ip_mreqn lo{group_.sin_addr, {htonl(INADDR_LOOPBACK)}, 0};
    option(in_, SOL_SOCKET, SO_REUSEADDR, 1);
    option(in_, IPPROTO_IP, IP_RECVTTL, 1);
    option(in_, IPPROTO_IP, IP_PKTINFO, 1);
    REQUIRE(::bind(in_.get(), generic(), sizeof group_) == 0);
    option(in_, IPPROTO_IP, IP_ADD_MEMBERSHIP, lo);
    option(out_, IPPROTO_IP, IP_MULTICAST_IF, lo);
    option(out_, IPPROTO_IP, IP_MULTICAST_TTL, 0);
  }

  void send(const Bytes& bytes) {
    const ssize_t sent =
        ::sendto(out_.get(), bytes.data(), bytes.size(), 0, generic(), sizeof group_);
    REQUIRE(sent == static_cast<ssize_t>(bytes.size()));
  }

  Datagram next() {
    REQUIRE(readable(in_.get()));
    Datagram got;
    got.bytes.resize(100);
    sockaddr_in from{};
    alignas(cmsghdr) std::array<char, 256> control{};
    iovec part{got.bytes.data(), got.bytes.size()};
    msghdr message{};
    message.msg_name = &from;
    message.msg_namelen = sizeof from;
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const ssize_t size = ::recvmsg(in_.get(), &message, MSG_DONTWAIT);
    REQUIRE(size >= 0);
    got.bytes.resize(static_cast<std::size_t>(size));
    got.from = inet_ntoa(from.sin_addr);
    for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c)) {
      if (c->cmsg_type == IP_TTL) std::memcpy(&got.time_to_live, CMSG_DATA(c), sizeof(int));
      if (c->cmsg_type != IP_PKTINFO) continue;
      in_pktinfo info{};
      std::memcpy(&info, CMSG_DATA(c), sizeof info);
      std::array<char, IF_NAMESIZE> name{};
      got.interface = if_indextoname(static_cast<unsigned>(info.ipi_ifindex), name.data());
    }
    return got;
  }

 private:
  template <class Value>
  static void option(const FileDescriptor& socket, int level, int name, const Value& value) {
    REQUIRE(::setsockopt(socket.get(), level, name, &value, sizeof value) == 0);
  }
  const sockaddr* generic() const { return reinterpret_cast<const sockaddr*>(&group_); }

  FileDescriptor in_{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  FileDescriptor out_{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  sockaddr_in group_{};
};

struct Golden {
  link::CanFrame frame;
  Bytes packet;
};

/// The three of tests/reference/dronecan_vectors.json, captured from pydronecan.
const std::array<Golden, 3> kGolden{{
    {{0x0704060A, 5, {0xFF, 0x7C, 0x02, 0x00, 0xC1}},
     {0x34, 0x29, 0x1E, 0x96, 0x00, 0x00, 0x0A, 0x06, 0x04, 0x87, 0xFF, 0x7C, 0x02, 0x00, 0xC1}},
    {{0x1801958A, 1, {0xC0}}, {0x34, 0x29, 0x54, 0x90, 0x00, 0x00, 0x8A, 0x95, 0x01, 0x98, 0xC0}},
    {{0x10040A15, 8, {0xAF, 0x3F, 0x00, 0x00, 0x00, 0x00, 0x20, 0x80}},
     {0x34, 0x29, 0xFE, 0xC8, 0x00, 0x00, 0x15, 0x0A, 0x04, 0x90, 0xAF, 0x3F, 0x00, 0x00, 0x00,
      0x00, 0x20, 0x80}},
}};

void check_same(const link::CanFrame& got, const link::CanFrame& expected) {
  CHECK(got.id == expected.id);
  CHECK(got.size == expected.size);
  CHECK(got.data == expected.data);
}

/// Checks that the next frame on `bus` is this one, so that no earlier one arrived.
void check_next(CanBus& bus, const link::CanFrame& expected) {
  link::CanFrame got;
  REQUIRE(next(bus, got));
  check_same(got, expected);
}

TEST_CASE("frames become exactly the captured datagrams, and datagrams exactly those frames") {
  const QuietBuses quiet;
  Wire wire(9);
  McastBus bus(9, std::nullopt);
  for (const Golden& golden : kGolden) {
    bus.send(std::span(&golden.frame, 1));
    CHECK(wire.next().bytes == golden.packet);
    wire.send(golden.packet);
    check_next(bus, golden.frame);
    wire.next();  // its own
  }
  CHECK(bus.counters().sent == 3);
  CHECK(bus.counters().received == 3);
  CHECK(bus.counters().bad_packets == 0);
  CHECK(bus.usable());
}

TEST_CASE("two programs on a bus hear each other in order, and not themselves") {
  const QuietBuses quiet;
  McastBus boat(9, std::nullopt), esc(9, std::nullopt);
  std::array<link::CanFrame, 3> transfer;
  for (std::uint8_t i = 0; i < 3; ++i) transfer[i] = {0x10040A15, 2, {i, 0x20}};
  boat.send(transfer);
  for (const link::CanFrame& frame : transfer) check_next(esc, frame);
  esc.send(std::span(&kGolden[0].frame, 1));
  check_next(boat, kGolden[0].frame);
  link::CanFrame none;
  CHECK_FALSE(boat.receive(none));
  CHECK_FALSE(esc.receive(none));
  CHECK(boat.counters().bad_packets == 0);
}

TEST_CASE("a bus hears nothing of the bus with the next number") {
  const QuietBuses quiet;
  McastBus eight(8, std::nullopt), nine(9, std::nullopt), other(9, std::nullopt);
  eight.send(std::span(&kGolden[0].frame, 1));
  other.send(std::span(&kGolden[1].frame, 1));
  check_next(nine, kGolden[1].frame);
  CHECK(nine.counters().received == 1);
}

TEST_CASE("datagrams that are no classic CAN frame with a 29-bit id are counted and forgotten") {
  const QuietBuses quiet;
  Wire wire(9);
  McastBus bus(9, std::nullopt);
  const Bytes& good = kGolden[0].packet;
  std::vector<Bytes> bad{{}, {0x34}, Bytes(9, 0x34), Bytes(1400, 0x34)};
  for (std::size_t i = 0; i < good.size(); ++i) {  // the checksum covers all but the magic
    bad.push_back(good);
    bad.back()[i] ^= 0x10U;
  }
  bad.push_back(good);
  bad.back().pop_back();
  // With a good checksum: 9 bytes of data; CAN FD; an 11-bit id; a remote frame
  bad.push_back({0x34, 0x29, 0x90, 0x4E, 0, 0, 0x0A, 0x06, 0x04, 0x87, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  bad.push_back({0x34, 0x29, 0x1B, 0xAF, 1, 0, 0x0A, 0x06, 0x04, 0x87, 0xC0});
  bad.push_back({0x34, 0x29, 0x50, 0xB8, 0, 0, 0x23, 0x01, 0x00, 0x00, 0xC0});
  bad.push_back({0x34, 0x29, 0xB6, 0x1A, 0, 0, 0x0A, 0x06, 0x04, 0xC7, 0xC0});
  for (const Bytes& packet : bad) wire.send(packet);
  wire.send(good);
  check_next(bus, kGolden[0].frame);
  CHECK(bus.counters().bad_packets == bad.size());
  CHECK(bus.counters().received == 1);
}

TEST_CASE("every length from 0 to 8 bytes passes, with the greatest id") {
  const QuietBuses quiet;
  McastBus boat(9, std::nullopt), esc(9, std::nullopt);
  for (std::uint8_t size = 0; size <= 8; ++size) {
    link::CanFrame frame{0x1FFFFFFF, size, {}};
    std::fill_n(frame.data.begin(), size, std::uint8_t{0xA5});
    boat.send(std::span(&frame, 1));
    check_next(esc, frame);
  }
}

TEST_CASE("simulated throttle commands stay on the machine unless an address is given") {
  const QuietBuses quiet;
  Wire wire(9);
  McastBus(9, std::nullopt).send(std::span(&kGolden[0].frame, 1));
  const auto inside = wire.next();
  CHECK(inside.time_to_live == 0);
  CHECK(inside.interface == "lo");
  CHECK(inside.from == "127.0.0.1");
  McastBus(9, in_addr{htonl(0x7F000002)}).send(std::span(&kGolden[0].frame, 1));
  const auto outside = wire.next();
  CHECK(outside.time_to_live == 1);
  CHECK(outside.from == "127.0.0.2");
}

TEST_CASE("a reader that is too slow learns how many frames the kernel threw away") {
  const QuietBuses quiet;
  McastBus boat(9, std::nullopt), esc(9, std::nullopt), witness(9, std::nullopt);
  const auto send_and_see = [&] {
    esc.send(std::span(&kGolden[0].frame, 1));
    check_next(witness, kGolden[0].frame);
  };
  constexpr std::uint64_t kSent = 600;
  for (std::uint64_t i = 0; i < kSent; ++i) send_and_see();
  link::CanFrame frame;
  while (boat.receive(frame)) {
  }
  const std::uint64_t received = boat.counters().received;
  CHECK(received < kSent);
  CHECK(boat.counters().receive_overflows == 0);  // the next frame brings the count
  send_and_see();
  REQUIRE(next(boat, frame));
  CHECK(boat.counters().receive_overflows == kSent - received);
}

TEST_CASE("maintaining a bus that works changes nothing") {
  const QuietBuses quiet;
  McastBus boat(9, std::nullopt), esc(9, std::nullopt);
  const int descriptor = boat.descriptor();
  boat.maintain();
  CHECK(boat.descriptor() == descriptor);
  CHECK(boat.counters().reopened == 0);
  esc.send(std::span(&kGolden[0].frame, 1));
  check_next(boat, kGolden[0].frame);
}

TEST_CASE("an interface whose address goes away: not usable, and opened again when it is back") {
  const char* add = "ip address add 198.51.100.7/32 dev lo";
  if (if_nametoindex("vcan0") == 0 || std::system(add) != 0) {
    MESSAGE("only in tools/with-vcan: it changes the machine's addresses");
    return;
  }
  const QuietBuses quiet;
  McastBus esc(9, std::nullopt), boat(9, in_addr{htonl(0xC6336407)});
  const std::span frame(&kGolden[0].frame, 1);
  REQUIRE(std::system("ip address delete 198.51.100.7/32 dev lo") == 0);
  boat.send(frame);
  CHECK_FALSE(boat.usable());
  boat.reopen();
  boat.maintain();
  boat.send(frame);
  CHECK_FALSE(boat.usable());
  CHECK(boat.counters().transfers_dropped == 2);
  CHECK(boat.counters().reopened == 0);

  REQUIRE(std::system(add) == 0);
  boat.reopen();
  boat.maintain();
  boat.send(frame);
  CHECK(boat.usable());
  CHECK(boat.counters().reopened == 1);
  check_next(esc, kGolden[0].frame);
  esc.send(frame);
  check_next(boat, kGolden[0].frame);
  REQUIRE(std::system("ip address delete 198.51.100.7/32 dev lo") == 0);
}

}  // namespace
}  // namespace flotilla::target
