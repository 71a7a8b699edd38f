// SPDX-License-Identifier: MIT
// tools/with-vcan build/dev/tests/socketcan_tests; without vcan0 it skips itself, with status 77.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "linux/can/socketcan_bus.hpp"

namespace flotilla::target {
namespace {

constexpr int kPatience_ms = 2000, kSkipped = 77;
constexpr std::uint8_t kBoat = 20;
const std::string kInterface = "vcan1";

// Priorities of a socket: urgent frames pass by the queue that slow_queue() makes.
constexpr int kUrgent = 6, kUsual = 0;

void shell(const std::string& command) {
  CAPTURE(command);
  REQUIRE(std::system(command.c_str()) == 0);
}

bool readable(int descriptor) {
  pollfd desired{descriptor, POLLIN, 0};
  return ::poll(&desired, 1, kPatience_ms) == 1;
}

bool operator==(const can_frame& a, const link::CanFrame& b) {
  return a.can_id == (b.id | CAN_EFF_FLAG) && a.len == b.size &&
         std::equal(b.bytes().begin(), b.bytes().end(), a.data);
}

/// Another node: a plain socket without any filter.
class Peer {
 public:
  explicit Peer(int priority = kUsual) {
    REQUIRE(::setsockopt(socket_.get(), SOL_SOCKET, SO_PRIORITY, &priority, sizeof priority) == 0);
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(if_nametoindex(kInterface.c_str()));
    REQUIRE(::bind(socket_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
  }

  bool send(canid_t id, std::array<std::uint8_t, 8> data = {}, std::uint8_t size = 8) {
    can_frame frame{};
    frame.can_id = id;
    frame.len = size;
    std::copy(data.begin(), data.end(), frame.data);
    return ::write(socket_.get(), &frame, sizeof frame) == sizeof frame;
  }

  std::optional<can_frame> next() {
    can_frame frame{};
    if (!readable(socket_.get())) return std::nullopt;
    if (::read(socket_.get(), &frame, sizeof frame) != sizeof frame) return std::nullopt;
    return frame;
  }

 private:
  FileDescriptor socket_{::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW)};
};

/// vcan1 exists and is up, with an empty queue, regardless of earlier tests.
struct Interface {
  Interface() {
    if (if_nametoindex(kInterface.c_str()) != 0) shell("ip link delete " + kInterface);
    shell("ip link add " + kInterface + " type vcan");
    shell("ip link set " + kInterface + " up");
  }
};

/// A queue as slow as a bus of about 16 kbit/s, `frames` long; urgent frames pass by.
void slow_queue(int frames) {
  const std::string add = "tc qdisc add dev " + kInterface;
  shell(add + " root handle 1: prio bands 2 priomap 1 1 1 1 1 1 0 0 1 1 1 1 1 1 1 1");
  shell(add + " parent 1:2 handle 2: tbf rate 8kbit burst 32 limit " + std::to_string(16 * frames));
}

constexpr link::CanFrame kRawCommand{0x0704060A, 5, {0xFF, 0x7C, 0x02, 0x00, 0xC1}};
constexpr canid_t kNodeStatusOf21 = CAN_EFF_FLAG | 0x14015515;

link::CanFrame numbered(std::uint8_t number) { return {0x0704060A, 2, {number, 0xC0}}; }

void send(SocketCanBus& bus, const link::CanFrame& frame) { bus.send(std::span(&frame, 1)); }

bool next(CanBus& bus, link::CanFrame& frame) {
  while (!bus.receive(frame)) {
    if (!readable(bus.descriptor())) return false;
  }
  return true;
}

/// Reads until `counter` has increased by 1.
bool await(SocketCanBus& bus, const std::uint64_t& counter) {
  const std::uint64_t desired = counter + 1;
  link::CanFrame frame;
  while (counter < desired) {
    if (!bus.receive(frame) && counter < desired && !readable(bus.descriptor())) return false;
  }
  return true;
}

TEST_CASE("the kernel delivers only the frames that a boat reads") {
  const Interface interface;
  SocketCanBus boat(kInterface, kBoat);
  Peer peer;
  const std::vector<canid_t> desired{
      0x10040A15, 0x00040A7F,              // esc.Status of nodes 21 and 127, of any priority
      0x14015515,                          // NodeStatus
      0x07040616, 0x07040716, 0x18044C16,  // another controller's commands and ArmingStatus
      0x0704060A, 0x07040614,              // also of a node with our id
      0x104E2030, 0x104E2130,              // SafetyState and Button of a stop switch
      0x1E000115,                          // dynamic_node_id.Allocation of an allocator
      0x1E285D00,                          // the same of a node without an id: discriminator 0xA17
      0x18019495, 0x1E0B1495,  // requests and responses to us: GetNodeInfo, param.GetSet
  };
  const std::vector<canid_t> not_for_us{
      CAN_EFF_FLAG | 0x07040815,                 // type 1032
      CAN_EFF_FLAG | 0x1E285E00,                 // of a node without an id, another type
      CAN_EFF_FLAG | 0x18019595,                 // a request to node 21
      CAN_EFF_FLAG | 0x1801D595,                 // ... to node 85
      CAN_EFF_FLAG | CAN_RTR_FLAG | 0x10040A15,  // a remote frame
      0x155,                                     // 11 bits
  };
  for (const canid_t id : not_for_us) CHECK(peer.send(id));
  for (const canid_t id : desired) CHECK(peer.send(CAN_EFF_FLAG | id, {1, 2, 3}, 3));
  for (const canid_t id : desired) {
    link::CanFrame frame;
    REQUIRE(next(boat, frame));
    CHECK(frame.id == id);
    CHECK(frame.size == 3);
    CHECK(frame.data == std::array<std::uint8_t, 8>{1, 2, 3});
  }
  CHECK(boat.counters().received == desired.size());
  CHECK(boat.counters().error_frames == 0);
}

TEST_CASE("frames sent by a boat reach other programs of this machine, but not itself") {
  const Interface interface;
  SocketCanBus boat(kInterface, kBoat), other(kInterface, 21);
  Peer peer;
  send(boat, kRawCommand);
  CHECK(peer.next().value() == kRawCommand);
  link::CanFrame frame;
  REQUIRE(next(other, frame));
  CHECK(frame.id == kRawCommand.id);
  CHECK(frame.data == kRawCommand.data);
  peer.send(kNodeStatusOf21);
  REQUIRE(next(boat, frame));
  CHECK((frame.id | CAN_EFF_FLAG) == kNodeStatusOf21);
  CHECK(boat.counters().sent == 1);
  CHECK(boat.counters().received == 1);
}

TEST_CASE("bus-off: nothing is sent; the controller's restart ends it at the next maintenance") {
  const Interface interface;
  SocketCanBus boat(kInterface, kBoat);
  Peer peer;
  CHECK(boat.usable());
  REQUIRE(peer.send(CAN_ERR_FLAG | CAN_ERR_BUSOFF));
  REQUIRE(await(boat, boat.counters().error_frames));
  CHECK_FALSE(boat.usable());
  CHECK(boat.counters().bus_off == 1);
  send(boat, numbered(1));
  boat.maintain();
  send(boat, numbered(2));
  CHECK(boat.counters().transfers_dropped == 2);

  REQUIRE(peer.send(CAN_ERR_FLAG | CAN_ERR_RESTARTED));
  REQUIRE(await(boat, boat.counters().error_frames));
  CHECK_FALSE(boat.usable());
  boat.maintain();
  CHECK(boat.usable());
  send(boat, numbered(3));
  CHECK(peer.next().value() == numbered(3));
  CHECK(boat.counters().bus_off == 1);
}

TEST_CASE("bus-off and restart within one reading: a tick sees it all the same") {
  const Interface interface;
  SocketCanBus boat(kInterface, kBoat);
  Peer peer;
  REQUIRE(peer.send(CAN_ERR_FLAG | CAN_ERR_BUSOFF));
  REQUIRE(peer.send(CAN_ERR_FLAG | CAN_ERR_RESTARTED));
  REQUIRE(peer.send(kNodeStatusOf21));
  link::CanFrame frame;
  REQUIRE(next(boat, frame));
  CHECK(boat.counters().error_frames == 2);
  CHECK_FALSE(boat.usable());
  boat.maintain();
  CHECK(boat.usable());
}

TEST_CASE("bus-off without a report of the restart: only a frame received later ends it") {
  const Interface interface;
  SocketCanBus boat(kInterface, kBoat);
  Peer peer;
  link::CanFrame frame;
  REQUIRE(peer.send(CAN_ERR_FLAG | CAN_ERR_BUSOFF));
  REQUIRE(peer.send(kNodeStatusOf21));  // was already in the controller
  REQUIRE(next(boat, frame));
  boat.maintain();
  boat.maintain();
  CHECK_FALSE(boat.usable());
  REQUIRE(peer.send(kNodeStatusOf21));
  REQUIRE(next(boat, frame));
  boat.maintain();
  CHECK(boat.usable());
}

TEST_CASE("every other error frame is counted and changes nothing") {
  const Interface interface;
  SocketCanBus boat(kInterface, kBoat);
  Peer peer;
  REQUIRE(peer.send(CAN_ERR_FLAG | CAN_ERR_CRTL, {0, CAN_ERR_CRTL_TX_PASSIVE}));
  REQUIRE(peer.send(CAN_ERR_FLAG | CAN_ERR_TX_TIMEOUT));
  REQUIRE(peer.send(CAN_ERR_FLAG | CAN_ERR_RESTARTED));
  REQUIRE(peer.send(kNodeStatusOf21));
  link::CanFrame frame;
  REQUIRE(next(boat, frame));
  CHECK(boat.counters().error_frames == 3);
  CHECK(boat.counters().bus_off == 0);
  CHECK(boat.usable());
}

TEST_CASE("after bus-off nothing is sent behind frames that still wait from before") {
  const Interface interface;
  SocketCanBus boat(kInterface, kBoat);
  slow_queue(100);
  Peer peer, controller(kUrgent);
  constexpr std::uint8_t kOld = 10;
  for (std::uint8_t i = 1; i <= kOld; ++i) send(boat, numbered(i));
  REQUIRE(controller.send(CAN_ERR_FLAG | CAN_ERR_BUSOFF));
  REQUIRE(await(boat, boat.counters().bus_off));
  REQUIRE(controller.send(CAN_ERR_FLAG | CAN_ERR_RESTARTED));
  REQUIRE(await(boat, boat.counters().error_frames));
  boat.maintain();
  CHECK(boat.usable());
  send(boat, numbered(50));
  CHECK(boat.counters().transfers_dropped == 1);
  for (std::uint8_t i = 1; i <= kOld; ++i) CHECK(peer.next().value() == numbered(i));
  send(boat, numbered(51));
  CHECK(peer.next().value() == numbered(51));
  CHECK(boat.counters().transfers_dropped == 1);
}

TEST_CASE("an interface that is down is not usable, and is again when it comes up") {
  const Interface interface;
  shell("ip link set " + kInterface + " down");
  SocketCanBus boat(kInterface, kBoat);
  CHECK_FALSE(boat.usable());
  CHECK(boat.descriptor() >= 0);
  link::CanFrame frame;
  for (int round = 0; round < 2; ++round) {
    CHECK_FALSE(boat.receive(frame));
    send(boat, numbered(1));
    shell("ip link set " + kInterface + " up");
    boat.maintain();
    CHECK(boat.usable());
    Peer peer;
    send(boat, numbered(2));
    CHECK(peer.next().value() == numbered(2));
    peer.send(kNodeStatusOf21);
    REQUIRE(next(boat, frame));

    shell("ip link set " + kInterface + " down");
    CHECK(readable(boat.descriptor()));  // poll() wakes up
    CHECK_FALSE(boat.receive(frame));
    CHECK_FALSE(boat.usable());
    boat.maintain();
    CHECK_FALSE(boat.usable());
  }
  CHECK(boat.counters().transfers_dropped == 2);
  CHECK(boat.counters().reopened == 0);
}

TEST_CASE("an interface that goes down is noticed by sending and by maintenance as well") {
  const Interface interface;
  SocketCanBus sender(kInterface, kBoat), idle(kInterface, kBoat);
  shell("ip link set " + kInterface + " down");
  send(sender, kRawCommand);
  CHECK_FALSE(sender.usable());
  CHECK(sender.counters().transfers_dropped == 1);
  idle.maintain();
  CHECK_FALSE(idle.usable());
}

TEST_CASE("a controller that was bus-off and is taken down and up is usable") {
  const Interface interface;
  SocketCanBus boat(kInterface, kBoat);
  Peer peer;
  REQUIRE(peer.send(CAN_ERR_FLAG | CAN_ERR_BUSOFF));
  REQUIRE(await(boat, boat.counters().bus_off));
  shell("ip link set " + kInterface + " down");
  boat.maintain();
  shell("ip link set " + kInterface + " up");
  boat.maintain();
  CHECK(boat.usable());
}

TEST_CASE("an interface that vanishes is opened again when it is back") {
  const Interface first;
  SocketCanBus boat(kInterface, kBoat);
  enum class Noticed { kByReading, kByWriting, kByMaintenance };
  for (const Noticed noticed :
       {Noticed::kByReading, Noticed::kByWriting, Noticed::kByMaintenance}) {
    shell("ip link delete " + kInterface);
    link::CanFrame frame;
    if (noticed == Noticed::kByReading) {
      CHECK(readable(boat.descriptor()));
      CHECK_FALSE(boat.receive(frame));
    }
    if (noticed == Noticed::kByWriting) send(boat, kRawCommand);
    if (noticed == Noticed::kByMaintenance) boat.maintain();
    CHECK_FALSE(boat.usable());
    CHECK(boat.descriptor() == -1);
    boat.maintain();
    CHECK_FALSE(boat.receive(frame));
    send(boat, kRawCommand);

    const Interface back;
    boat.reopen();
    boat.maintain();
    CHECK(boat.usable());
    Peer peer;
    send(boat, kRawCommand);
    CHECK(peer.next().value() == kRawCommand);
    peer.send(kNodeStatusOf21);
    CHECK(next(boat, frame));
  }
  CHECK(boat.counters().reopened == 3);
  CHECK(boat.counters().transfers_dropped == 4);
}

TEST_CASE("an interface that vanishes and returns between two checks is opened again") {
  const Interface first;
  SocketCanBus boat(kInterface, kBoat);
  const Interface second;
  link::CanFrame frame;
  CHECK_FALSE(boat.receive(frame));
  boat.reopen();
  boat.maintain();
  CHECK(boat.usable());
  CHECK(boat.counters().reopened == 1);
  Peer peer;
  send(boat, kRawCommand);
  CHECK(peer.next().value() == kRawCommand);
}

TEST_CASE("an interface that is not there yet is opened when it comes") {
  const Interface present;
  shell("ip link delete " + kInterface);
  const auto boat = open_can_bus("socketcan:" + kInterface, kBoat);
  CHECK_FALSE(boat->usable());
  CHECK(boat->descriptor() == -1);
  boat->send(std::span(&kRawCommand, 1));
  boat->reopen();
  boat->maintain();
  CHECK(boat->counters().transfers_dropped == 1);
  const Interface came;
  boat->reopen();
  boat->maintain();
  CHECK(boat->usable());
}

TEST_CASE("an interface of another kind is reported, and never opened") {
  const auto boat = open_can_bus("socketcan:lo", kBoat);
  boat->reopen();
  boat->maintain();
  CHECK_FALSE(boat->usable());
  CHECK(boat->fault() == "not a CAN interface");
}

TEST_CASE("a full queue: transfers that find no room are dropped whole and counted") {
  const Interface interface;
  SocketCanBus boat(kInterface, kBoat);
  slow_queue(10);
  Peer peer;
  std::vector<link::CanFrame> frames;
  for (std::uint8_t i = 0; i < 20; ++i) {  // 20 transfers of 3 frames
    for (const std::uint8_t tail : std::array<std::uint8_t, 3>{0x80, 0x20, 0x40}) {
      frames.push_back({0x10040A14, 8, {i, 0, 0, 0, 0, 0, 0, tail}});
    }
  }
  boat.send(frames);
  const std::uint64_t sent = boat.counters().sent, dropped = boat.counters().transfers_dropped;
  CHECK(sent >= 10);
  CHECK(sent < 20);
  CHECK(dropped == 20 - sent / 3);  // what was begun and dropped may have left 1 or 2 frames
  CHECK(boat.usable());
  std::size_t whole = 0;
  for (std::uint64_t i = 0; i < sent; ++i) {
    const auto got = peer.next();
    REQUIRE(got);
    whole += (got->data[7] & 0x40U) != 0 ? 1U : 0U;
  }
  CHECK(whole == 20 - dropped);
  send(boat, kRawCommand);  // there is room again
  CHECK(peer.next().value() == kRawCommand);
  CHECK(boat.counters().transfers_dropped == dropped);
}

TEST_CASE("however long the interface's queue, few frames of ours ever wait") {
  const Interface interface;
  SocketCanBus boat(kInterface, kBoat);
  slow_queue(10000);
  while (boat.counters().transfers_dropped == 0 && boat.counters().sent < 1000) {
    send(boat, kRawCommand);
  }
  CHECK(boat.counters().sent >= 20);
  CHECK(boat.counters().sent <= 50);
}

TEST_CASE("a reader that is too slow learns how many frames the kernel threw away") {
  const Interface interface;
  SocketCanBus boat(kInterface, kBoat);
  Peer peer, witness;
  const auto send_and_see = [&] {
    REQUIRE(peer.send(kNodeStatusOf21));
    REQUIRE(witness.next());  // so the kernel is done with this frame
  };
  constexpr std::uint64_t kSent = 600;
  for (std::uint64_t i = 0; i < kSent; ++i) send_and_see();
  link::CanFrame frame;
  while (boat.receive(frame)) {
  }
  const std::uint64_t received = boat.counters().received;
  CHECK(received > 100);
  CHECK(received < kSent);
  for (int i = 0; i < 2; ++i) {
    send_and_see();  // receives the report, if there is one
    REQUIRE(boat.receive(frame));
    CHECK(boat.counters().receive_overflows == kSent - received);
  }
}

}  // namespace
}  // namespace flotilla::target

int main(int argc, char** argv) {
  const flotilla::target::FileDescriptor probe(::socket(PF_CAN, SOCK_RAW, CAN_RAW));
  if (!probe || if_nametoindex("vcan0") == 0) {
    std::puts("skipped: no AF_CAN or no vcan0 here; tools/with-vcan runs these tests");
    return flotilla::target::kSkipped;
  }
  return doctest::Context(argc, argv).run();
}
