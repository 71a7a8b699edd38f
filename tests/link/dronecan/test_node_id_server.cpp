// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>

#include "link/dronecan/node_id_server.hpp"

namespace flotilla::link {
namespace {

NodeIdServer::UniqueId unique(std::uint8_t seed) {
  NodeIdServer::UniqueId id{};
  for (std::size_t i = 0; i < id.size(); ++i) id[i] = static_cast<std::uint8_t>(seed + i);
  return id;
}

/// Sends the three requests of a node, 10 ms apart; returns the last answer.
std::optional<Allocation> ask(NodeIdServer& server, const NodeIdServer::UniqueId& id,
                              std::uint8_t wish = 0) {
  std::optional<Allocation> answer;
  for (std::uint8_t at = 0; at < 16; at = static_cast<std::uint8_t>(at + 6)) {
    Allocation request{wish, at == 0, static_cast<std::uint8_t>(std::min(6, 16 - at)), {}};
    std::copy_n(id.begin() + at, request.size, request.unique_id.begin());
    answer = server.answer(request, at * 10'000);
  }
  return answer;
}

TEST_CASE("a node gets the id it requests, else the next above, else below") {
  NodeIdServer server(20);
  CHECK(ask(server, unique(1), 50)->node_id == 50);
  CHECK(ask(server, unique(2), 50)->node_id == 51);
  CHECK(ask(server, unique(3), 125)->node_id == 125);
  CHECK(ask(server, unique(4), 125)->node_id == 124);
  CHECK(ask(server, unique(5))->node_id == 123);
  CHECK(ask(server, unique(6), 20)->node_id == 21);  // 20 is the allocator itself
}

TEST_CASE("a returning node gets its old id, whatever it requests now") {
  NodeIdServer server(20);
  CHECK(ask(server, unique(1), 50)->node_id == 50);
  CHECK(ask(server, unique(1), 60)->node_id == 50);
  CHECK(server.table().size() == 1);
}

TEST_CASE("a restored table is as it was, and assigns no id twice") {
  NodeIdServer server(20);
  CHECK(server.restore({unique(1), 50}));
  CHECK_FALSE(server.restore({unique(2), 50}));
  CHECK_FALSE(server.restore({unique(1), 51}));
  CHECK_FALSE(server.restore({unique(3), 20}));
  CHECK_FALSE(server.restore({unique(3), 0}));
  CHECK_FALSE(server.restore({unique(3), 126}));
  CHECK(ask(server, unique(1))->node_id == 50);
}

TEST_CASE("a full table assigns no more ids, and keeps those that it assigned") {
  NodeIdServer server(20);
  for (std::uint8_t i = 0; i < 32; ++i) {
    REQUIRE(ask(server, unique(static_cast<std::uint8_t>(7 * i))));
  }
  CHECK_FALSE(ask(server, unique(250)));
  CHECK(ask(server, unique(0))->node_id == 125);
}

TEST_CASE("parts out of turn, too late or of the wrong length are not answered") {
  NodeIdServer server(20);
  const Allocation first{0, true, 6, unique(1)}, second{0, false, 6, unique(7)};
  CHECK_FALSE(server.answer(second, 0));
  CHECK(server.answer(first, 0));
  CHECK_FALSE(server.answer(second, 600'000));
  CHECK(server.answer(first, 600'000));
  CHECK_FALSE(server.answer(Allocation{0, false, 4, unique(7)}, 610'000));
  CHECK(server.answer(second, 620'000)->size == 12);
  CHECK_FALSE(server.answer(Allocation{0, true, 16, unique(1)}, 630'000));
}

}  // namespace
}  // namespace flotilla::link
