// SPDX-License-Identifier: MIT
// Sends telemetry on every link as its bandwidth allows: first the state that followers need, then
// the formation's reference and future, then in turn the other streams and the answers that need
// many messages.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "app/operator/mavlink_links.hpp"
#include "app/operator/services/log_service.hpp"
#include "app/operator/services/parameter_service.hpp"
#include "app/operator/telemetry/streams.hpp"
#include "app/operator/telemetry/telemetry.hpp"
#include "app/schedule.hpp"
#include "link/mavlink/ftp_server.hpp"

namespace flotilla::app {

class TelemetrySender {
 public:
  /// Sources of the data to send. All must outlive this object.
  struct Sources {
    const Report& report;
    const Parameters& parameters;
    ParameterService& parameter_service;
    link::FtpServer& files;
    LogService& logs;
  };

  /// streams: one element for each link; like links, must outlive this object.
  TelemetrySender(const Configuration& configuration, MavlinkLinks& links,
                  std::span<Streams::Link> streams, const Sources& sources);

  Streams& streams() { return streams_; }
  const Streams& streams() const { return streams_; }

  void begin(std::int64_t now_us);

  /// Sets the origin of the positions that we send. Returns whether it has changed; if so, it is
  /// announced, because followers need it to convert our positions.
  bool locate(const link::GpsGlobalOrigin& origin);
  bool is_located() const { return origin_.has_value(); }

  /// Whether send() or send_separation() needs a report of this tick.
  bool needs_report();

  /// Sends DEPTH and SEP_M once a second: DEPTH decides the right of way among nearby boats; SEP_M
  /// shows operators why this boat stops.
  void send_separation(link::Counters& counters);

  /// Whether FORMATION_REFERENCE is due on a link; it is due earlier if `news` differs from the
  /// number sent last.
  bool waits_for_reference(std::uint32_t news) const;
  void send_reference(std::uint32_t news, const link::FormationReference& reference,
                      link::Counters& counters);

  /// The same for FORMATION_FUTURE; each future is sent twice. future: nothing once it has ended.
  bool waits_for_future(std::uint32_t news) const;
  void send_future(std::uint32_t news, const std::optional<link::FormationFuture>& future,
                   link::Counters& counters);

  /// Sends whatever else is due.
  void send(link::Counters& counters);

 private:
  /// The state messages of one tick, shared by all links.
  using StateMessages = std::array<std::optional<link::Message>, kStateStreams.size()>;
  struct StateTurns {
    std::uint8_t states = 0;      ///< sent since the last reference
    bool reference_next = false;  ///< a reference waits for the link's budget
  };
  struct ToldFuture {
    std::uint32_t news = 0;
    bool again = false;
  };
  struct Begun {
    std::uint8_t stream = kStreams.size();
    std::uint32_t sent = 0;
  };
  struct Turns {
    std::uint8_t next = 0;  ///< turn of send_rest()
    Begun begun;            ///< a stream that has sent only part of its messages
    std::uint32_t told_news = 0;
    StateTurns states;
    ToldFuture future;
  };

  bool state_is_due();
  bool reference_is_due(std::size_t link, std::uint32_t news) const;
  bool future_is_due(std::size_t link, std::uint32_t news) const;
  void send_state(link::Counters& counters);
  void send_state(std::size_t link, StateMessages& state, link::Counters& counters);
  void send_rest(std::size_t link, link::Counters& counters);
  bool has_room(std::size_t link) const;
  bool send_stream(std::uint8_t stream, std::size_t link, link::Counters& counters);
  bool send_parameters(std::size_t link, link::Counters& counters);
  /// Sends up to `most` messages that the service owes this link.
  template <class Service>
  bool send_from(Service& service, int most, std::size_t link, link::Counters& counters);

  MavlinkLinks& links_;
  Sources from_;
  Streams streams_;
  std::optional<std::array<std::int32_t, 2>> origin_;
  bool origin_moved_ = false;  // in this tick
  std::array<Turns, kMaxLinks> turns_{};
  std::int64_t now_us_ = 0;
  Schedule separation_due_;
};

}  // namespace flotilla::app
