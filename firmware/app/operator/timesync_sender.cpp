// SPDX-License-Identifier: MIT
#include "app/operator/timesync_sender.hpp"

namespace flotilla::app {

void TimesyncSender::ask(std::int64_t now_us, std::uint8_t self, const Streams& streams,
                         link::Counters& counters) {
  if (!due_.take_if_due(now_us)) return;
  const link::Timesync request = time_.ask(now_us, self);
  const unsigned own = router_.links_to({self, 0}, now_us);
  const std::int64_t second = now_us / kSecond_us;
  for (std::size_t link = 0; link < links_.count(); ++link) {
    // Once in each such period, also if ticks come seldom.
    const std::int64_t period_s = streams.slowed_us(link, kSecond_us) / kSecond_us;
    const bool turn = period_s <= 1 || !last_s_ || second / period_s != *last_s_ / period_s;
    if (turn || (own >> link & 1U) != 0) links_.send(link, request, counters);
  }
  last_s_ = second;
}

void TimesyncSender::ask_leader(std::int64_t now_us, std::uint8_t self, std::uint8_t leader,
                                link::Counters& counters) {
  if (!leader_due_.take_if_due(now_us)) return;
  link::Timesync request = time_.ask(now_us, self);
  request.target = {leader, 0};
  links_.broadcast(request, counters);
}

}  // namespace flotilla::app
