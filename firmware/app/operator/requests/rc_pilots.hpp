// SPDX-License-Identifier: MIT
// The pilots of RC: one at a transmitter, and one whose ground station sends overrides.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "app/operator/requests/copies.hpp"
#include "app/operator/requests/rc_input.hpp"
#include "app/supervisor.hpp"

namespace flotilla::app {

/// The pilot at the transmitter goes first.
class RcPilots {
 public:
  /// Limits on the messages that count.
  struct Rules {
    std::optional<std::uint8_t> mode_switch;  ///< its channel; without one, RC is ignored
    std::uint8_t own_system;                  ///< of the receiver
    bool may_override;                        ///< this message, if it is an override
  };

  /// Takes RC_CHANNELS and RC_CHANNELS_OVERRIDE, and the receiver's health from SYS_STATUS; passes
  /// the sticks of a pilot who has taken over to the supervisor. False if the message is to be
  /// treated as any other.
  [[gnu::noinline]] bool take(std::size_t link, const link::Received& received, const Rules& rules,
                              Supervisor& supervisor, std::int64_t now_us);

  /// A pilot's switch is on.
  bool hold(std::int64_t now_us) const {
    return transmitter_.holds(now_us) || overrides_.holds(now_us);
  }
  /// The pilot at the transmitter has taken over, and a stick is off neutral.
  bool steer(std::int64_t now_us) const { return transmitter_.steers(now_us); }

  /// The pending request, MANUAL or HOLD.
  std::optional<core::Request> take_request(core::State state, std::int64_t now_us);

 private:
  RcInput transmitter_, overrides_;
  StreamLink overrides_link_;
};

}  // namespace flotilla::app
