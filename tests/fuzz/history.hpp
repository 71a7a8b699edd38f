// SPDX-License-Identifier: MIT
// A boat among senders that act as its navigation unit, leader, operator and ESCs, and sometimes
// send what nobody should: one op after another from the fuzzer.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>

#include "fuzz/can_ops.hpp"
#include "fuzz/mavlink_ops.hpp"
#include "fuzz/setups.hpp"
#include "fuzz/vessel.hpp"

namespace flotilla::fuzz {

/// The first byte of each op, modulo kOps; seeds.py writes them by the same numbers.
enum class Op : std::uint8_t {
  kSail,     ///< that many ticks + 1
  kStep,     ///< the time a tick takes from now on, one of kSteps_us
  kTalk,     ///< the senders in every tick from now on, kTalk… bits
  kAsk,      ///< one of the requests that lead from state to state
  kSticks,   ///< x, r as int8 of 127, from now on
  kVessel,   ///< moves own or leader's vessel: place, heading, speeds, or its clock or way to tell
  kBytes,    ///< link and flags as in fuzz_mavlink, length, bytes
  kMessage,  ///< sender, link, any message
  kCommand,  ///< any COMMAND_LONG
  kParameter,  ///< any PARAM_SET
  kFrame,      ///< any CAN frame
  kTransfer,   ///< any DroneCAN transfer
  kEsc,        ///< the ESCs' reports from now on
  kHost,       ///< what the host reports
  kClock,      ///< the host's clock jumps, by int32 ms
  kRestart,    ///< a new process with the same parameters
  kLink,       ///< a link's rate; whether talkers sign
  kPlan,       ///< a plan of up to 15 items around the boat, in MAVLink's dialogue
  kCount
};

enum Talk : std::uint8_t {
  kTalkNavigation = 1,
  kTalkLeader = 2,
  kTalkPort = 4,
  kTalkStbd = 8,
  kTalkOperator = 16,
  kTalkSticks = 32,
  kTalkOther = 64,
  kTalkImpostor = 128,  ///< another vessel under the leader's system id
};

/// States that any history of this process has reached, one bit each; with a fence.
inline unsigned states_reached = 0, states_fenced = 0;

template <class S>
class History {
 public:
  explicit History(const Setup& setup) : setup_(setup) { start(); }

  void run(Stream& in) {
    while (!in.empty() && ticks_ < kMaxTicks) op(in);
    tick();
  }

 private:
  static constexpr int kMaxTicks = 1500;
  static constexpr std::int64_t kEscs_us = 100'000, kSecond_us = 1'000'000;

  void start();
  void op(Stream& in);
  void ask(std::uint8_t what);
  void vessel(Stream& in);
  void esc(Stream& in);
  void host(Stream& in);
  void any_command(Stream& in);
  void plan(Stream& in);
  void answer_time(const link::Timesync& request);
  void talk();
  void talk_bus();
  void tell(Talkers<S>& talkers, std::uint8_t who, const Vessel& vessel);
  void tick();

  Setup setup_;
  std::optional<WatchedBoat<S>> boat_;
  std::optional<Talkers<S>> talkers_;
  bool sign_ = false;
  std::int64_t now_us_ = 1'000'000, step_us_ = kSteps_us[0], clock_us_ = 0;
  std::int64_t escs_due_us_ = 0, second_due_us_ = 0;
  int ticks_ = 0;
  std::uint8_t talk_ = kTalkNavigation | kTalkLeader | kTalkPort | kTalkStbd;
  Vessel own_, leader_, other_;
  link::ManualControl sticks_{0, 0, 0, 0, 0, 1};
  std::array<link::EscStatus, 2> escs_{};
  link::NodeStatus node_{};
  std::uint8_t transfer_id_ = 0;
  app::HostReport host_;
  core::Thrust<double> thrust_N_{};
};

}  // namespace flotilla::fuzz
