// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "link/ftp_client.hpp"
#include "link/mavlink/crc32.hpp"

namespace flotilla::link {
namespace {

using namespace testing;

TEST_CASE("a client that opens a file and bursts gets all of it, and then its end") {
  for (const std::uint8_t size : std::initializer_list<std::uint8_t>{239, 80, 1, 0, 238}) {
    Harbour harbour;
    Client client{harbour};
    client.seq = 65'000;  // it wraps on the way
    for (const FtpFile& file : harbour.files) {
      const Fields opened = client.ask(kOpen, 0, std::string(file.name));
      CHECK(opened.opcode == kAck);
      CHECK(opened.number() == file.content.size());
      const auto packets = client.burst(0, 0, size);
      std::string received;
      std::uint16_t seq = client.seq;
      for (const Fields& packet : packets) {
        if (file.content.size() == 0) break;
        CHECK(packet.opcode == kAck);
        CHECK(packet.seq == ++seq);
        CHECK(packet.offset == received.size());
        received += packet.data;
        const bool last = received.size() == file.content.size();
        if (!last) CHECK(packet.size == (size == 0 ? 239 : size));
        CHECK(packet.complete == (last ? 1 : 0));
      }
      CHECK(received == text_of(file.content));
      const auto length = static_cast<std::uint32_t>(file.content.size());
      CHECK(client.error(kBurst, 0, {}, length, 239) == kEnd);
      CHECK(client.error(kTerminate, 0) == 0);
    }
  }
}

TEST_CASE("a read gives the bytes requested, at the end the remainder, and then the end") {
  Harbour harbour;
  Client client{harbour};
  client.ask(kOpen, 3, "big.json");
  CHECK(client.ask(kRead, 3, {}, 4321, 100).data == harbour.big.substr(4321, 100));
  CHECK(client.ask(kRead, 3, {}, 0, 239).data == harbour.big.substr(0, 239));
  CHECK(client.ask(kRead, 3, {}, 7, 0).data == harbour.big.substr(7, 239));
  const Fields tail = client.ask(kRead, 3, {}, 9'990, 239);
  CHECK(tail.data == harbour.big.substr(9'990));
  CHECK(tail.complete == 0);
  for (const std::uint32_t offset : {10'000U, 10'001U, 0x8000'0000U, 0xFFFF'FFFFU}) {
    CHECK(client.error(kRead, 3, {}, offset, 239) == kEnd);
    CHECK(client.error(kBurst, 3, {}, offset, 239) == kEnd);
  }
}

TEST_CASE("each client chooses its own session numbers, even numbers that other clients use") {
  Harbour harbour;
  Client first{harbour}, second{harbour, {255, 191}}, third{harbour, {255, 190}, 1};
  first.ask(kOpen, 0, "big.json");
  first.ask(kOpen, 200, "even");
  second.ask(kOpen, 0, "digits");
  third.ask(kOpen, 0, "even");
  CHECK(first.ask(kRead, 0, {}, 0, 20).data == harbour.big.substr(0, 20));
  CHECK(first.ask(kRead, 200, {}, 0, 20).data == harbour.even.substr(0, 20));
  CHECK(second.ask(kRead, 0, {}, 0, 20).data == "123456789");
  CHECK(third.ask(kRead, 0, {}, 0, 20).data == harbour.even.substr(0, 20));
  CHECK(second.error(kRead, 200, {}, 0, 20) == kBadSession);
  CHECK(second.error(kBurst, 1, {}, 0, 20) == kBadSession);
  first.ask(kOpen, 0, "digits");  // again, without closing it
  CHECK(first.ask(kRead, 0, {}, 0, 20).data == "123456789");
}

TEST_CASE("closing closes one session, a reset all of that client's and of nobody else") {
  Harbour harbour;
  Client first{harbour}, second{harbour, {250, 190}};
  first.ask(kOpen, 1, "even");
  first.ask(kOpen, 2, "even");
  second.ask(kOpen, 1, "even");
  CHECK(first.error(kTerminate, 1) == 0);
  CHECK(first.error(kRead, 1, {}, 0, 9) == kBadSession);
  CHECK(first.error(kRead, 2, {}, 0, 9) == 0);
  CHECK(first.error(kReset, 0) == 0);
  CHECK(first.error(kRead, 2, {}, 0, 9) == kBadSession);
  CHECK(second.error(kRead, 1, {}, 0, 9) == 0);
}

TEST_CASE("a client's third session replaces the one that it has not used for longest") {
  Harbour harbour;
  Client client{harbour}, other{harbour, {250, 190}};
  other.ask(kOpen, 1, "even");
  client.ask(kOpen, 1, "even");
  client.ask(kOpen, 2, "even");
  client.ask(kRead, 1, {}, 0, 9);
  client.ask(kOpen, 3, "even");
  CHECK(client.error(kRead, 1, {}, 0, 9) == 0);
  CHECK(client.error(kRead, 2, {}, 0, 9) == kBadSession);
  CHECK(client.error(kRead, 3, {}, 0, 9) == 0);
  CHECK(other.error(kRead, 1, {}, 0, 9) == 0);
}

TEST_CASE("a ninth session replaces the one that was not used for longest") {
  Harbour harbour;
  std::vector<Client> clients;
  for (std::uint8_t i = 0; i < 9; ++i) clients.push_back({harbour, {i, 190}});
  for (std::size_t i = 0; i < 8; ++i) clients[i].ask(kOpen, 7, "even");
  clients[0].ask(kRead, 7, {}, 0, 9);
  clients[8].ask(kOpen, 7, "even");
  CHECK(clients[1].error(kRead, 7, {}, 0, 9) == kBadSession);
  for (const std::size_t i : {0U, 2U, 3U, 4U, 5U, 6U, 7U, 8U}) {
    CHECK(clients[i].error(kRead, 7, {}, 0, 9) == 0);
  }
}

TEST_CASE("paths are found with and without their slash and their NUL, others are not") {
  Harbour harbour;
  Client client{harbour};
  using namespace std::string_literals;
  for (const auto& path : {"even"s, "/even"s, "even\0"s, "/even\0"s, "//even\0\0x"s}) {
    CHECK(client.ask(kOpen, 0, path).number() == harbour.even.size());
  }
  for (const auto& path : {""s, "/"s, "."s, "eve"s, "evens"s, "EVEN"s, "a/even"s, "../even"s,
                           "@PARAM/param.pck?withdefaults=1"s, std::string(239, 'x')}) {
    CHECK(client.error(kOpen, 0, path) == kNotFound);
    CHECK(client.error(kCrc, 0, path) == kNotFound);
  }
  CHECK(client.error(kList, 0, "/even") == kNotFound);
  CHECK(client.error(kList, 0, "@PARAM") == kNotFound);
}

TEST_CASE("the root is listed with sizes, in as many parts as it takes") {
  using namespace std::string_literals;
  Harbour harbour;
  Client client{harbour};
  for (const auto& path : {""s, "/"s, "."s, "/."s, "/\0"s, "\0"s}) {
    CHECK(client.ask(kList, 0, path).data ==
          "Fbig.json\t10000\0Feven\t478\0Fempty\t0\0Fdigits\t9\0"s);
    CHECK(client.ask(kList, 0, path, 3).data == "Fdigits\t9\0"s);
    CHECK(client.error(kList, 0, path, 4) == kEnd);
    CHECK(client.error(kList, 0, path, 0xFFFF'FFFF) == kEnd);
  }

  std::vector<std::string> names;
  std::string expected;
  for (int i = 0; i < 50; ++i) {
    names.push_back("file-" + std::string(static_cast<std::size_t>(i), 'x'));
    expected += "F" + names.back() + "\t9\0"s;
  }
  harbour.files.clear();
  for (const std::string& name : names) harbour.files.push_back({name, "123456789"});
  harbour.server = FtpServer(harbour.files);
  std::string listed;
  for (std::uint32_t offset = 0; offset < names.size();) {
    const Fields part = client.ask(kList, 0, "/", offset);
    offset += static_cast<std::uint32_t>(std::ranges::count(part.data, '\0'));
    listed += part.data;
  }
  CHECK(listed == expected);
}

TEST_CASE("a file's checksum is MAVLink's") {
  Harbour harbour;
  Client client{harbour};
  // zlib.crc32(b"123456789", 0xFFFFFFFF) ^ 0xFFFFFFFF
  CHECK(client.ask(kCrc, 0, "/digits").number() == 0x2DFD2D88);
  CHECK(client.ask(kCrc, 0, "empty").number() == 0);
  static_assert(~crc32(0xFFFFFFFF, "123456789") == 0xCBF43926);  // zlib.crc32(b"123456789")
}

TEST_CASE("writing and unknown requests are refused, and an answer is never answered") {
  Harbour harbour;
  Client client{harbour};
  client.ask(kOpen, 0, "even");
  for (int i = 0; i < 256; ++i) {
    const auto opcode = static_cast<std::uint8_t>(i);
    if (opcode == kAck || opcode == kNak) {
      client.send({1, 0, opcode, 1, 0, 0, 0, "x"});
      CHECK_FALSE(client.next());
      continue;
    }
    const bool known = opcode <= kRead || opcode == kCrc || opcode == kBurst;
    if (!known) CHECK(client.error(opcode, 0, "even") == kUnknown);
    CHECK(client.error(opcode, 0, {}, 0, 240) == kBadSize);
    CHECK(client.error(opcode, 0, {}, 0, 255) == kBadSize);
  }
  CHECK(client.error(kNone, 0) == 0);
  CHECK(client.error(kRead, 0, {}, 0, 9) == 0);  // none of that has closed it
}

TEST_CASE("a repeated request gets the same answer") {
  Harbour harbour;
  Client client{harbour};
  for (const Fields& request : std::vector<Fields>{{0, 5, kOpen, 0, 0, 0, 0, "even"},
                                                   {0, 5, kRead, 9, 0, 0, 70, {}},
                                                   {0, 5, kRead, 9, 0, 0, 900, {}},
                                                   {0, 5, kList, 0, 0, 0, 1, "/"},
                                                   {0, 5, kCrc, 0, 0, 0, 0, "big.json"},
                                                   {0, 5, kTerminate, 0, 0, 0, 0, {}},
                                                   {0, 5, kReset, 0, 0, 0, 0, {}}}) {
    const Fields answer = client.ask(request);
    CHECK(client.ask(request) == answer);
  }
}

TEST_CASE("a repeated sequence number with another request is another request") {
  Harbour harbour;
  Client client{harbour};
  CHECK(client.ask({0, 0, kOpen, 0, 0, 0, 0, "even"}).number() == harbour.even.size());
  CHECK(client.ask({0, 0, kOpen, 0, 0, 0, 0, "digits"}).number() == 9);
  CHECK(client.ask({0, 0, kRead, 9, 0, 0, 2, {}}).data == "3456789");
}

TEST_CASE("a burst requested again starts again") {
  Harbour harbour;
  Client client{harbour};
  client.ask(kOpen, 0, "big.json");
  const Fields request{50, 0, kBurst, 239, 0, 0, 1000, {}};
  client.send(request);
  const auto first = client.next();
  CHECK(client.next() != first);
  client.send(request);
  CHECK(client.next() == first);
}

TEST_CASE("a client's next request ends its burst, not another's") {
  Harbour harbour;
  Client client{harbour}, other{harbour, {250, 190}, 1};
  other.ask(kOpen, 0, "big.json");
  other.send({8, 0, kBurst, 239, 0, 0, 0, {}});
  for (const std::uint8_t opcode : {kTerminate, kReset, kList, kOpen, kNone, kCrc}) {
    client.ask(kOpen, 0, "big.json");
    client.send({8, 0, kBurst, 239, 0, 0, 0, {}});
    REQUIRE(client.next());
    client.send({9, 0, opcode, 0, 0, 0, 0, {}});
    CHECK(client.next()->asked == opcode);
    CHECK_FALSE(client.next());
    CHECK(other.next());
  }
}

TEST_CASE("a client that reads missed bytes gets them first, and its burst goes on") {
  Harbour harbour;
  Client client{harbour};
  client.ask(kOpen, 0, "big.json");
  client.send({8, 0, kBurst, 239, 0, 0, 0, {}});
  REQUIRE(client.next());
  client.send({9, 0, kRead, 239, 0, 0, 0, {}});
  CHECK(client.next()->asked == kRead);
  CHECK(client.next()->offset == 239);
}

TEST_CASE("clients on one link get bursts in turn, and a newcomer no more than its share") {
  Harbour harbour;
  std::vector<Client> clients{{harbour, {1, 1}}, {harbour, {2, 1}}, {harbour, {3, 1}, 1}};
  for (Client& client : clients) client.ask(kOpen, 0, "big.json");
  for (Client& client : clients) client.send({8, 0, kBurst, 239, 0, 0, 0, {}});
  std::map<std::uint8_t, int> packets;
  for (int i = 0; i < 20; ++i) {
    ++packets[harbour.server.next(0)->target.system];
    CHECK(harbour.server.next(1)->target.system == 3);
  }
  CHECK(packets[1] == 10);
  CHECK(packets[2] == 10);
  Client late{harbour, {4, 1}, 1};
  late.send({0, 0, kList, 0, 0, 0, 0, "/"});
  CHECK(harbour.server.next(1)->target.system == 3);
  CHECK(harbour.server.next(1)->target.system == 4);
  CHECK(harbour.server.next(1)->target.system == 3);
}

TEST_CASE("a ninth client replaces an idle one, or else the longest silent one") {
  Harbour harbour;
  std::vector<Client> clients;
  for (std::uint8_t i = 0; i < 10; ++i) clients.push_back({harbour, {i, 190}});
  const auto start_burst = [](Client& client) {
    client.send({6, 0, kOpen, 0, 0, 0, 0, "big.json"});
    client.send({8, 0, kBurst, 239, 0, 0, 0, {}});
  };
  const auto served = [&] {  // who has packets waiting
    std::set<std::uint8_t> systems;
    for (int i = 0; i < 40; ++i) systems.insert(harbour.server.next(0)->target.system);
    return systems;
  };
  for (std::size_t i = 0; i < 7; ++i) start_burst(clients[i]);
  clients[7].send({0, 0, kNone, 0, 0, 0, 0, {}});
  CHECK(served() == std::set<std::uint8_t>{0, 1, 2, 3, 4, 5, 6, 7});
  start_burst(clients[8]);
  CHECK(served() == std::set<std::uint8_t>{0, 1, 2, 3, 4, 5, 6, 8});
  start_burst(clients[0]);
  start_burst(clients[9]);
  CHECK(served() == std::set<std::uint8_t>{0, 2, 3, 4, 5, 6, 8, 9});
}

TEST_CASE("consecutive requests are answered in order; of too many, some are not") {
  Harbour harbour;
  Client client{harbour};
  client.ask(kOpen, 0, "big.json");
  for (std::uint16_t i = 0; i < 100; ++i) client.send({i, 0, kRead, 9, 0, 0, i * 9U, {}});
  std::uint16_t answers = 0;
  while (const auto answer = client.next()) CHECK(answer->seq == ++answers);
  CHECK(answers == 8);
  CHECK(client.error(kRead, 0, {}, 0, 9) == 0);
}

/// Bursts, then reads the missing parts until the file is complete; any packet may be lost.
std::string download_over_bad_radio(Harbour& harbour, Client& client, std::uint32_t seed,
                                    auto&& others) {
  std::mt19937 random(seed);
  const auto lost = [&] { return random() % 10 < 3; };
  const auto exchange = [&](const Fields& request) {
    if (!lost()) client.send(request);
    others();
    std::vector<Fields> heard;
    for (int i = 0; i < 20; ++i) {
      const auto message = harbour.server.next(client.link);
      if (message && message->target == client.address && !lost()) {
        heard.push_back(unpacked(*message));
      }
    }
    return heard;
  };
  std::map<std::uint32_t, std::string> parts;
  bool is_open = false;
  std::uint16_t seq = 0;
  for (std::uint32_t offset = 0, tries = 0; offset < harbour.big.size() && tries < 2000; ++tries) {
    const Fields request = is_open ? Fields{seq, 1, kBurst, 239, 0, 0, offset, {}}
                                   : Fields{seq, 1, kOpen, 0, 0, 0, 0, "/big.json"};
    for (const Fields& packet : exchange(request)) {
      ++seq;
      if (packet.asked == kOpen) is_open = packet.opcode == kAck;
      if (packet.asked == kBurst && packet.opcode == kAck) parts[packet.offset] = packet.data;
      if (packet.opcode == kNak) is_open = false;
    }
    while (parts.contains(offset)) offset += static_cast<std::uint32_t>(parts[offset].size());
  }
  std::string file;
  for (const auto& [offset, data] : parts) file += data;
  return file;
}

TEST_CASE("a client that loses a third of all packets still gets the whole file") {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    Harbour harbour;
    Client client{harbour};
    CHECK(download_over_bad_radio(harbour, client, seed, [] {}) == harbour.big);
  }
}

FileTransferProtocol noise(std::mt19937& random) {
  FileTransferProtocol message{{1, 1}, {}};
  for (std::uint8_t& byte : message.payload) byte = static_cast<std::uint8_t>(random());
  auto& p = message.payload;
  if (random() % 4 != 0) p[3] = static_cast<std::uint8_t>(random() % 17);  // an opcode that exists
  if (random() % 4 != 0) p[2] = static_cast<std::uint8_t>(random() % 4);
  if (random() % 2 != 0) p[9] = p[10] = p[11] = 0;  // an offset within a file
  if (random() % 2 != 0) std::ranges::copy(std::string_view("/big.json\0", 10), p.begin() + 12);
  return message;
}

TEST_CASE("whatever is received, answers are valid and no more than requested") {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    Harbour harbour;
    std::size_t asked = 0, answered = 0;
    for (int i = 0; i < 5000; ++i) {
      const Address from{static_cast<std::uint8_t>(random() % 6),
                         static_cast<std::uint8_t>(random() % 4)};
      harbour.server.request(random() % 3, from, noise(random),
                             harbour.now_us += random() % 2 == 0 ? 0 : 5);
      ++asked;
      if (random() % 2 == 0) continue;
      if (const auto message = harbour.server.next(random() % 3)) {
        const Fields answer = unpacked(*message);
        CHECK(message->target.system < 6);
        CHECK((answer.opcode == kAck || answer.opcode == kNak));
        if (answer.opcode == kNak) CHECK(answer.error() != 0);
        if (answer.asked == kBurst && answer.opcode == kAck) {
          CHECK(answer.size > 0);
        } else {
          ++answered;
        }
      }
    }
    for (std::size_t link = 0; link < 3; ++link) {
      for (int i = 0; harbour.server.next(link); ++i) REQUIRE(i < 8 * 10'000 + 64);  // ends
    }
    CHECK(answered > 100);
    CHECK(answered <= asked);
    Client client{harbour};
    CHECK(client.ask(kOpen, 0, "even").number() == harbour.even.size());
    CHECK(client.burst(0).size() == 2);
  }
}

TEST_CASE("a client gets its file over a bad radio while strangers flood the boat") {
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    Harbour harbour;
    Client client{harbour};
    const auto flood = [&] {
      for (int i = 0; i < 6; ++i) {
        const Address from{static_cast<std::uint8_t>(random() % 250), 1};
        harbour.server.request(0, from, noise(random), harbour.now_us += 1000);
      }
    };
    CHECK(download_over_bad_radio(harbour, client, seed, flood) == harbour.big);
  }
}

}  // namespace
}  // namespace flotilla::link
