// SPDX-License-Identifier: MIT
// A boat whose whole output is checked: no tick may break these rules, whatever the input was.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <span>

#include "app/boat/boat.hpp"
#include "fuzz/guard.hpp"
#include "fuzz/wire_numbers.hpp"
#include "link/dronecan/messages.hpp"
#include "policies/monitor.hpp"

namespace flotilla::fuzz {

/// The key of all boats and all senders that sign here.
constexpr link::SigningKey kKey{7, 1, 2, 3, 250, 251, 252, 253};
constexpr std::uint64_t kSigningClock = 40'000'000'000'000;

struct Setup {
  app::Parameters parameters;
  std::size_t links = 1;
  app::SigningPolicy policy = app::SigningPolicy::kOff;  ///< of link 0; the others have none
};

template <class S>
class WatchedBoat {
 public:
  explicit WatchedBoat(const Setup& setup)
      : setup_(setup),
        boat_(setup.parameters, setup.links),
        monitor_(setup.parameters),
        self_(boat_.self()) {
    boat_.secure(kKey, kSigningClock, 0);
    boat_.set_policy(0, setup.policy);
    boat_.logs().open();
    verifier_.start(kKey, 0, 0);
  }

  const app::Boat<S>& boat() const { return boat_; }
  std::size_t links() const { return setup_.links; }

  void on_mavlink(std::span<const std::uint8_t> data, std::int64_t now_us, std::size_t link) {
    {
      const Guard guard;
      boat_.on_mavlink(data, now_us, link);
    }
    monitor_.heard(data);
  }
  void end_of_datagram(std::int64_t now_us, std::size_t link) {
    const Guard guard;
    boat_.end_of_datagram(now_us, link);
  }
  void on_can(const link::CanFrame& frame, std::int64_t now_us) {
    {
      const Guard guard;
      boat_.on_can(frame.id, frame.bytes(), now_us);
    }
    monitor_.on_can(frame.id, frame.bytes());
  }
  void on_host(const app::HostReport& report) { boat_.on_host(report); }
  void disarm() { boat_.disarm(); }
  void limit_link(std::size_t link, std::uint32_t bytes_per_s) {
    boat_.limit_link(link, bytes_per_s);
    if (bytes_per_s != 0 && bytes_per_s <= 5'760) monitor_.know_slow_link();
  }

  /// The last TIMESYNC request that the boat sent; returned once.
  std::optional<link::Timesync> take_time_request() {
    return std::exchange(time_request_, std::nullopt);
  }

  /// Checks the commands to the ESCs.
  const link::RawCommand& tick(std::int64_t now_us) {
    const auto out = [&] {
      const Guard guard;
      return boat_.tick(now_us);
    }();
    judge_bus(out.can, now_us);
    for (std::size_t link = 0; link < setup_.links; ++link)
      judge_link(out.links->bytes(link), link);
    self_ = boat_.self();
    bring_logs();
    judge_snapshot(boat_.snapshot());
    const auto violation = monitor_.ticked(boat_, out, now_us);
    require(!violation, violation ? violation->name.data() : "");
    return command_;
  }

 private:
  static constexpr std::uint8_t kTimesync = 111;

  /// The host's logs: one is empty, one is shorter than its list says.
  void bring_logs() {
    static constexpr std::array<app::StoredLog, 4> kList{{{0, 1}, {200, 2}, {99'999, 3}, {7, 4}}};
    static constexpr std::array<std::uint8_t, 500> kBytes{1, 2, 3};
    const Guard guard;
    const auto request = boat_.logs().request();
    if (!request) return;
    if (request->list) return boat_.logs().bring_list(kList);
    const std::size_t at = std::min<std::size_t>(request->offset, kBytes.size());
    boat_.logs().bring(*request, std::span(kBytes).subspan(at));
  }

  void judge_bus(std::span<const link::CanFrame> frames, std::int64_t now_us) {
    int commands = 0;
    for (const link::CanFrame& frame : frames) {
      const auto route = link::route_of(frame.id);
      require(route && route->source == static_cast<std::uint8_t>(setup_.parameters.CAN_NODE),
              "frames on the bus are sound and bear the boat's node id");
      if (route->kind != link::TransferKind::kMessage) continue;
      const bool command = route->type == link::RawCommand::kType.id;
      if (!command && route->type != link::ArmingStatus::kType.id) continue;
      const auto type = command ? link::RawCommand::kType : link::ArmingStatus::kType;
      const auto transfer = bus_.push(*route, type, frame.bytes(), now_us, counters_);
      if (!transfer) continue;
      if (command) {
        command_ = link::read_raw_command(transfer->payload).value();
        ++commands;
      } else {
        const std::uint8_t status = link::read_arming_status(transfer->payload)->status;
        require(status == (core::armed(boat_.state()) ? 255 : 0), "ArmingStatus says the state");
        arming_ = status;
      }
    }
    require(commands == 1, "one RawCommand a tick");
    require(arming_ == (core::armed(boat_.state()) ? 255 : 0), "ArmingStatus follows at once");
    judge_command();
  }

  void judge_command() const {
    const auto port = static_cast<std::size_t>(boat_.parameters().ESC_PORT),
               stbd = static_cast<std::size_t>(boat_.parameters().ESC_STBD);
    const core::State state = boat_.state();
    const bool still = state == core::State::kDisarmed || state == core::State::kHold ||
                       state == core::State::kFault;
    require(command_.count == std::max(port, stbd) + 1, "RawCommand reaches to the last propeller");
    for (std::size_t i = 0; i < command_.count; ++i) {
      require(std::abs(int{command_.cmd[i]}) <= 8191, "no command exceeds full scale");
      require(i == port || i == stbd || command_.cmd[i] == 0, "others' ESCs are told zero");
      require(!still || command_.cmd[i] == 0, "disarmed, HOLD, FAULT: all commands are zero");
    }
  }

  void judge_link(std::span<const std::uint8_t> bytes, std::size_t link) {
    const bool has_signature = link == 0 && setup_.policy != app::SigningPolicy::kOff;
    const link::Address self = boat_.self();
    while (!bytes.empty()) {
      const std::size_t size = frame_size(bytes);
      require(size > 0, "only whole frames leave, with good checksums");
      const auto frame = bytes.first(size);
      bytes = bytes.subspan(size);
      // Frames of other senders are forwarded. After the boat has changed its ids, they cannot be
      // distinguished.
      const bool own = frame[0] == 0xFD && frame[5] == self.system && frame[6] == self.component;
      if (!own || self != self_) continue;
      require(unsound_number(frame) == nullptr, "no number that is not finite leaves");
      if (has_signature) judge_signature(frame);
      if (frame[7] == kTimesync && frame[8] == 0 && frame[1] > 8) note_time_request(frame);
    }
  }

  void note_time_request(std::span<const std::uint8_t> frame) {
    link::MavlinkDecoder decoder;
    link::Counters counters;
    decoder.fill(frame);
    const auto received = decoder.next(counters);
    const auto* const request =
        received ? std::get_if<link::Timesync>(&received->message) : nullptr;
    if (request != nullptr && request->tc1 == 0) time_request_ = *request;
  }

  void judge_signature(std::span<const std::uint8_t> frame) {
    require((frame[2] & 1U) != 0, "all is signed on a link with a key");
    std::uint64_t stamp = 0;
    for (std::size_t i = 0; i < 6; ++i) {
      stamp |= std::uint64_t{frame[frame.size() - 12 + i]} << 8 * i;
    }
    verifier_.set_clock(stamp);
    require(verifier_.check(frame) == link::SignatureVerdict::kGood,
            "signatures are good, and each is newer than the one before");
  }

  static void judge_snapshot(const app::Snapshot& s) {
    const std::array numbers{s.own_age_s.value_or(0),
                             s.leader_age_s.value_or(0),
                             s.leader_uncertainty_m.value_or(0),
                             s.estimates.unknown.X,
                             s.estimates.unknown.N,
                             s.estimates.current_n.x,
                             s.estimates.current_n.y,
                             s.error.x,
                             s.error.y,
                             s.error.psi,
                             s.nu_star.u,
                             s.nu_star.v,
                             s.nu_star.r,
                             s.asked.X,
                             s.asked.N,
                             s.given.X,
                             s.given.N,
                             s.thrust_N.port,
                             s.thrust_N.stbd};
    require(std::ranges::all_of(numbers, [](double x) { return std::isfinite(x); }),
            "every number of the snapshot is finite");
  }

  Setup setup_;
  app::Boat<S> boat_;
  policies::Monitor<S> monitor_;
  link::Address self_;
  link::TransferReceiver bus_;
  link::Counters counters_;
  link::RawCommand command_{};
  std::optional<std::uint8_t> arming_;
  std::array<link::Signing::Stream, 255> verified_;
  link::Signing verifier_{verified_};
  std::optional<link::Timesync> time_request_;
};

}  // namespace flotilla::fuzz
