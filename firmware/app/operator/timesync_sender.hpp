// SPDX-License-Identifier: MIT
// Asks other vessels for their time, by TIMESYNC: all of them once a second, a new leader more
// often.
#pragma once

#include <cstdint>
#include <optional>

#include "app/navigation/time_requests.hpp"
#include "app/operator/mavlink_links.hpp"
#include "app/operator/router.hpp"
#include "app/operator/telemetry/streams.hpp"
#include "app/schedule.hpp"

namespace flotilla::app {

class TimesyncSender {
 public:
  /// All must outlive this.
  TimesyncSender(TimeRequests& time, MavlinkLinks& links, const Router& router,
                 std::int64_t tick_us)
      : time_(time), links_(links), router_(router), due_(kSecond_us, tick_us / 2) {}

  /// Call in every tick. All vessels in range answer each request, which makes up most of a slow
  /// radio's load; so the others are asked as often as slow telemetry is sent. Our own unit is
  /// asked every second, because it counts as late if it does not answer.
  void ask(std::int64_t now_us, std::uint8_t self, const Streams& streams,
           link::Counters& counters);

  /// Asks a new leader whose clock offset is unknown; the boat coasts until it is known.
  void ask_leader(std::int64_t now_us, std::uint8_t self, std::uint8_t leader,
                  link::Counters& counters);

  /// Asks all at the next call.
  void make_due() {
    due_.make_due();
    last_s_.reset();
  }

 private:
  static constexpr std::int64_t kSecond_us = 1'000'000;

  TimeRequests& time_;
  MavlinkLinks& links_;
  const Router& router_;
  Schedule due_, leader_due_{kSecond_us / 4};
  std::optional<std::int64_t> last_s_;  // when ask() last sent requests, s
};

}  // namespace flotilla::app
