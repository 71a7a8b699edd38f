// SPDX-License-Identifier: MIT
#include "app/operator/timesync_sender.hpp"

namespace flotilla::app {

void TimesyncSender::ask(std::int64_t now_us, std::uint8_t self, const Streams& streams,
                         link::Counters& counters) {
  if (!due_.take_if_due(now_us)) return;
  const link::Timesync request = time_.ask(now_us, self);
  const unsigned own = router_.links_to({self, 0}, now_us);
  for (std::size_t link = 0; link < links_.count(); ++link) {
    const auto seconds =
        static_cast<std::uint32_t>(streams.slowed_us(link, kSecond_us) / kSecond_us);
    if (turn_ % seconds == 0 || (own >> link & 1U) != 0) links_.send(link, request, counters);
  }
  ++turn_;
}

void TimesyncSender::ask_leader(std::int64_t now_us, std::uint8_t self, std::uint8_t leader,
                                link::Counters& counters) {
  if (!leader_due_.take_if_due(now_us)) return;
  link::Timesync request = time_.ask(now_us, self);
  request.target = {leader, 0};
  links_.broadcast(request, counters);
}

}  // namespace flotilla::app
