// SPDX-License-Identifier: MIT
// An independent client of MAVLink FTP, and a server with files.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "link/mavlink/ftp_server.hpp"

namespace flotilla::link::testing {

constexpr std::uint8_t kNone = 0, kTerminate = 1, kReset = 2, kList = 3, kOpen = 4, kRead = 5,
                       kCrc = 14, kBurst = 15, kAck = 128, kNak = 129;
constexpr std::uint8_t kBadSize = 3, kBadSession = 4, kEnd = 6, kUnknown = 7, kNotFound = 10;

/// The fields of a packet; bytes in the order of the protocol's page.
struct Fields {
  std::uint16_t seq = 0;
  std::uint8_t session = 0, opcode = 0, size = 0, asked = 0, complete = 0;
  std::uint32_t offset = 0;
  std::string data{};
  bool operator==(const Fields&) const = default;

  std::uint8_t error() const { return static_cast<std::uint8_t>(data.at(0)); }
  std::uint32_t number() const {
    REQUIRE(data.size() == 4);
    std::uint32_t n = 0;
    for (std::size_t i = 4; i > 0; --i) n = n << 8U | static_cast<std::uint8_t>(data[i - 1]);
    return n;
  }
};

inline FileTransferProtocol packed(const Fields& f) {
  FileTransferProtocol message{{1, 1}, {}};
  auto& p = message.payload;
  const auto byte = [](std::uint32_t n) { return static_cast<std::uint8_t>(n); };
  p = {byte(f.seq),
       byte(f.seq >> 8U),
       f.session,
       f.opcode,
       f.size,
       f.asked,
       f.complete,
       0,
       byte(f.offset),
       byte(f.offset >> 8U),
       byte(f.offset >> 16U),
       byte(f.offset >> 24U)};
  std::copy(f.data.begin(), f.data.end(), p.begin() + 12);
  return message;
}

inline Fields unpacked(const FileTransferProtocol& message) {
  const auto& p = message.payload;
  Fields f{
      static_cast<std::uint16_t>(p[0] | p[1] << 8),
      p[2],
      p[3],
      p[4],
      p[5],
      p[6],
      p[8] | std::uint32_t{p[9]} << 8U | std::uint32_t{p[10]} << 16U | std::uint32_t{p[11]} << 24U};
  REQUIRE(f.size <= 239);
  REQUIRE(p[7] == 0);
  REQUIRE(std::all_of(p.begin() + 12 + f.size, p.end(), [](std::uint8_t b) { return b == 0; }));
  f.data.assign(p.begin() + 12, p.begin() + 12 + f.size);
  return f;
}

inline std::string content_of(std::size_t size, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::string content(size, '\0');
  for (char& c : content) c = static_cast<char>(random());
  return content;
}

/// The text of a file, whole.
inline std::string text_of(const PackedText& content) {
  std::vector<std::uint8_t> bytes(content.size());
  REQUIRE(content.read(0, bytes) == bytes.size());
  return {bytes.begin(), bytes.end()};
}

struct Harbour {
  std::string big = content_of(10'000, 1), even = content_of(2 * 239, 2);
  std::vector<FtpFile> files{
      {"big.json", big}, {"even", even}, {"empty", ""}, {"digits", "123456789"}};
  FtpServer server{files};
  std::int64_t now_us = 0;
};

/// A ground station.
struct Client {
  Harbour& harbour;
  Address address{255, 190};
  std::size_t link = 0;
  std::uint16_t seq = 0;

  void send(Fields request) {
    seq = request.seq;
    if (request.size == 0) request.size = static_cast<std::uint8_t>(request.data.size());
    harbour.server.request(link, address, packed(request), harbour.now_us += 1000);
  }
  std::optional<Fields> next() {
    const auto message = harbour.server.next(link);
    if (!message) return std::nullopt;
    CHECK(message->target == address);
    return unpacked(*message);
  }
  /// The one answer to a request.
  Fields ask(const Fields& request) {
    send(request);
    const auto answer = next();
    REQUIRE(answer);
    CHECK(answer->seq == static_cast<std::uint16_t>(request.seq + 1));
    CHECK(answer->session == request.session);
    CHECK(answer->asked == request.opcode);
    CHECK(answer->offset == request.offset);
    if (answer->opcode == kNak) CHECK(answer->size == 1);
    CHECK_FALSE(next());
    return *answer;
  }
  Fields ask(std::uint8_t opcode, std::uint8_t session, const std::string& data = {},
             std::uint32_t offset = 0, std::uint8_t size = 0) {
    return ask({seq += 2, session, opcode, size, 0, 0, offset, data});
  }
  std::uint8_t error(std::uint8_t opcode, std::uint8_t session, const std::string& data = {},
                     std::uint32_t offset = 0, std::uint8_t size = 0) {
    const Fields answer = ask(opcode, session, data, offset, size);
    return answer.opcode == kNak ? answer.error() : std::uint8_t{0};
  }
  std::vector<Fields> burst(std::uint8_t session, std::uint32_t offset = 0,
                            std::uint8_t size = 239) {
    send({seq += 2, session, kBurst, size, 0, 0, offset, {}});
    std::vector<Fields> packets;
    while (const auto packet = next()) packets.push_back(*packet);
    return packets;
  }
};

}  // namespace flotilla::link::testing
