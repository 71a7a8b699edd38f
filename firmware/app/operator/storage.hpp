// SPDX-License-Identifier: MIT
// The memory that a boat works in. It is the owner's, who knows how many links there are: nothing in
// a boat grows.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "app/operator/mavlink_links.hpp"
#include "app/operator/parameter_service.hpp"
#include "app/operator/router.hpp"
#include "app/operator/streams.hpp"
#include "app/propulsion/can_node.hpp"
#include "link/mavlink/signing.hpp"

namespace flotilla::app {

/// What a boat keeps of its links, and of those who sign what it hears.
template <std::size_t kLinks, std::size_t kSigningStreams>
struct LinkRoom {
  std::array<MavlinkLinks::Link, kLinks> links;
  std::array<Router::Link, kLinks> routes;
  std::array<ParameterService::Owed, kLinks> parameters;
  std::array<Streams::Link, kLinks> streams;
  std::array<link::Signing::Stream, kSigningStreams> signing;
};

/// Where a boat puts what it says in a tick. Boats that tick one after another may share it.
template <std::size_t kLinks>
struct Outbox {
  std::array<Datagram, kLinks> mavlink;
  CanOutput can;
};

/// Both, as a boat takes them; its owner keeps them for as long as the boat.
struct Storage {
  template <std::size_t kLinks, std::size_t kSigningStreams>
  Storage(LinkRoom<kLinks, kSigningStreams>& room, Outbox<kLinks>& outbox)
      : links(room.links),
        routes(room.routes),
        parameters(room.parameters),
        streams(room.streams),
        signing(room.signing),
        mavlink(outbox.mavlink),
        can(outbox.can) {}

  std::span<MavlinkLinks::Link> links;
  std::span<Router::Link> routes;
  std::span<ParameterService::Owed> parameters;
  std::span<Streams::Link> streams;
  std::span<link::Signing::Stream> signing;
  std::span<Datagram> mavlink;
  CanOutput& can;
};

/// For whom memory is no matter: room for the most that there can be.
struct AmpleStorage {
  LinkRoom<kMaxLinks, 255> room;
  Outbox<kMaxLinks> outbox;
};

}  // namespace flotilla::app
