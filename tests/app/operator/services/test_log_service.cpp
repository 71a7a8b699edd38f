// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "app/operator/services/log_service.hpp"

namespace flotilla::app {
namespace {

struct Shelf {
  std::array<StoredLog, 3> list;
  std::array<std::uint8_t, 200> piece;
  std::array<LogRange, 2> ranges;
  LogService service{{list, piece, ranges}, false};
  std::vector<std::uint8_t> bytes = std::vector<std::uint8_t>(500);

  Shelf() {
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * 7);
    service.open();
    service.list(0, {{}, 0, 0xFFFF});
    service.bring_list(std::array{StoredLog{500, 9}});
    while (service.next(0)) continue;
  }
  void read(std::uint32_t offset, std::uint32_t count) {
    REQUIRE(service.read(0, {{}, 0, offset, count}).empty());
  }
  void bring(std::size_t kept) {
    const auto request = service.request();
    REQUIRE(request);
    const std::size_t at = std::min<std::size_t>(request->offset, kept);
    service.bring(*request, std::span(bytes).first(kept).subspan(at));
  }
  std::vector<link::LogData> all(std::size_t kept = 500) {
    std::vector<link::LogData> out;
    while (!service.is_idle()) {
      if (const auto m = service.next(0)) {
        out.push_back(std::get<link::LogData>(*m));
      } else {
        bring(kept);
      }
    }
    return out;
  }
};

TEST_CASE("a log longer than a piece comes in order, and byte by byte the same") {
  Shelf shelf;
  shelf.read(0, 0xFFFF'FFFF);
  std::size_t at = 0;
  for (const auto& m : shelf.all()) {
    REQUIRE(m.ofs == at);
    for (std::size_t i = 0; i < m.count; ++i) REQUIRE(m.data[i] == shelf.bytes[at++]);
  }
  CHECK(at == 500);
  CHECK_FALSE(shelf.service.request());
}

TEST_CASE("a log that was cut off or removed since it was listed ends there") {
  for (const std::size_t kept : {0U, 1U, 90U, 199U, 200U, 250U}) {
    CAPTURE(kept);
    Shelf shelf;
    shelf.read(0, 0xFFFF'FFFF);
    std::size_t bytes = 0;
    for (const auto& m : shelf.all(kept)) bytes += m.count;
    CHECK(bytes == kept);
  }
}

TEST_CASE("a gap requested twice is not sent twice, and one request too many is ignored") {
  Shelf shelf;
  shelf.read(0, 180);
  shelf.read(90, 90);
  shelf.read(360, 90);
  shelf.read(180, 90);
  const auto sent = shelf.all();
  REQUIRE(sent.size() == 3);
  CHECK(sent[2].ofs == 360);
}

TEST_CASE("log data that was not requested is not accepted") {
  Shelf shelf;
  shelf.service.bring({false, 0, 0}, shelf.bytes);
  shelf.service.bring_list(std::array{StoredLog{1, 1}, StoredLog{2, 2}});
  shelf.read(0, 90);
  shelf.service.bring({false, 0, 90}, shelf.bytes);
  CHECK_FALSE(shelf.service.next(0));
  shelf.bring(500);
  CHECK(shelf.service.next(0));
  CHECK_FALSE(shelf.service.next(0));
}

TEST_CASE("without a host there are no logs, and no memory is used") {
  LogService none({}, false);
  none.list(1, {{}, 0, 0xFFFF});
  CHECK_FALSE(none.request());
  CHECK_FALSE(none.next(0));
  REQUIRE(none.next(1));
  CHECK(none.is_idle());
  CHECK_FALSE(none.read(1, {{}, 0, 0, 90}).empty());
}

}  // namespace
}  // namespace flotilla::app
