// SPDX-License-Identifier: MIT
// A boat's working memory, sized by its owner for the number of links. A boat allocates nothing.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "app/operator/mavlink_links.hpp"
#include "app/operator/router.hpp"
#include "app/operator/services/log_service.hpp"
#include "app/operator/services/mission_service.hpp"
#include "app/operator/services/parameter_service.hpp"
#include "app/operator/telemetry/streams.hpp"
#include "app/propulsion/can_node.hpp"
#include "link/mavlink/signing.hpp"

namespace flotilla::app {

/// Memory for links, signing streams, plan, fence, rally points and one upload. With kLogs > 0 also
/// for the log list, one log block and a client's missing ranges.
template <std::size_t kLinks, std::size_t kSigningStreams, std::size_t kPlanItems,
          std::size_t kFenceItems, std::size_t kRallyPoints, std::size_t kLogs = 0>
struct Room {
  std::array<MavlinkLinks::Link, kLinks> links;
  std::array<Router::Link, kLinks> routes;
  std::array<ParameterService::Owed, kLinks> parameters;
  std::array<Streams::Link, kLinks> streams;
  std::array<link::Signing::Stream, kSigningStreams> signing;
  std::array<PlanItem, kPlanItems> plan;
  std::array<PlanItem, kFenceItems> fence;
  std::array<PlanItem, kRallyPoints> rally;
  std::array<PlanItem, std::max({kPlanItems, kFenceItems, kRallyPoints})> incoming;
  std::array<Fence::Place, kFenceItems> corners;
  std::array<StoredLog, kLogs> logs;
  std::array<std::uint8_t, kLogs == 0 ? 0 : 256 * sizeof(link::LogData::data)> log_piece;
  std::array<LogRange, kLogs == 0 ? 0 : 24> log_gaps;
};

/// A boat's output of one tick. Boats that tick one after another may share it.
template <std::size_t kLinks>
struct Outbox {
  std::array<Datagram, kLinks> mavlink;
  CanOutput can;
};

/// Refers to a Room and an Outbox for a boat; their owner keeps them for the boat's lifetime.
struct Storage {
  template <std::size_t kLinks, std::size_t kSigningStreams, std::size_t kPlanItems,
            std::size_t kFenceItems, std::size_t kRallyPoints, std::size_t kLogs>
  Storage(Room<kLinks, kSigningStreams, kPlanItems, kFenceItems, kRallyPoints, kLogs>& room,
          Outbox<kLinks>& outbox)
      : links(room.links),
        routes(room.routes),
        parameters(room.parameters),
        streams(room.streams),
        signing(room.signing),
        missions{{room.plan, room.fence, room.rally}, room.incoming, room.corners},
        logs{room.logs, room.log_piece, room.log_gaps},
        mavlink(outbox.mavlink),
        can(outbox.can) {}

  std::span<MavlinkLinks::Link> links;
  std::span<Router::Link> routes;
  std::span<ParameterService::Owed> parameters;
  std::span<Streams::Link> streams;
  std::span<link::Signing::Stream> signing;
  MissionRoom missions;
  LogRoom logs;
  std::span<Datagram> mavlink;
  CanOutput& can;
};

/// For hosts with ample memory: room for the maximum of everything.
struct AmpleStorage {
  Room<kMaxLinks, 255, 1000, 200, 50, 250> room;
  Outbox<kMaxLinks> outbox;
};

}  // namespace flotilla::app
