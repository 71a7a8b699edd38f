// SPDX-License-Identifier: MIT
// Whole histories of a boat; history.hpp explains them.
#include <cstdio>
#include <cstdlib>

#include "app/operator/telemetry/text.hpp"
#include "fuzz/history.hpp"

namespace flotilla::fuzz {
namespace {

constexpr std::array kCommands{link::mav::kCmdComponentArmDisarm,
                               link::mav::kCmdDoSetMode,
                               link::mav::kCmdDoMotorTest,
                               link::mav::kCmdDoFlightTermination,
                               link::mav::kCmdPreflightStorage,
                               link::mav::kCmdRequestMessage,
                               link::mav::kCmdGetMessageInterval,
                               link::mav::kCmdRequestAutopilotCapabilities,
                               link::mav::kCmdRequestProtocolVersion,
                               link::mav::kCmdSetMessageInterval,
                               link::mav::kCmdDoSetStandardMode,
                               link::mav::kCmdMissionStart,
                               link::mav::kCmdDoPauseContinue,
                               link::mav::kCmdDoSetMissionCurrent,
                               link::mav::kCmdDoFenceEnable,
                               link::mav::kCmdNavReturnToLaunch,
                               link::mav::kCmdGetHomePosition};
/// Commands in plans; the last one is unknown to boats.
constexpr std::array<std::uint16_t, 13> kItems{link::mav::kNavWaypoint,
                                               link::mav::kNavLoiterUnlimited,
                                               link::mav::kNavLoiterTime,
                                               link::mav::kNavDelay,
                                               link::mav::kDoChangeSpeed,
                                               link::mav::kDoSetRoi,
                                               link::mav::kFenceInclusion,
                                               link::mav::kFenceExclusion,
                                               link::mav::kFenceCircleInclusion,
                                               link::mav::kFenceCircleExclusion,
                                               link::mav::kFenceReturnPoint,
                                               link::mav::kRallyPoint,
                                               20};

/// Numbers with a special meaning in some message.
float any_param(Stream& in) {
  const std::uint8_t choice = in.byte();
  if (choice == 255) return in.number<float>();
  if (choice == 254) return float(in.number<std::uint16_t>());
  if (choice == 253) return std::numeric_limits<float>::quiet_NaN();
  if (choice == 252) return 21196;
  return float(choice) - 20;
}

}  // namespace

template <class S>
void History<S>::start() {
  boat_.emplace(setup_);
  talkers_.emplace(*boat_, setup_.parameters);
  talkers_->sign(sign_);
  thrust_N_ = {};
}

template <class S>
void History<S>::op(Stream& in) {
  const auto push = [&](const link::CanFrame& frame) { boat_->on_can(frame, now_us_); };
  const auto link = [&] { return in.byte() % boat_->links(); };
  switch (static_cast<Op>(in.byte() % static_cast<unsigned>(Op::kCount))) {
    case Op::kSail:
      for (int n = in.byte(); n >= 0 && ticks_ < kMaxTicks; --n) tick();
      break;
    case Op::kStep:
      step_us_ = in.one_of(kSteps_us);
      break;
    case Op::kTalk:
      talk_ = in.byte();
      break;
    case Op::kAsk:
      ask(in.byte());
      break;
    case Op::kSticks:
      sticks_.x = static_cast<std::int16_t>(in.number<std::int8_t>() * 1000 / 127);
      sticks_.r = static_cast<std::int16_t>(in.number<std::int8_t>() * 1000 / 127);
      break;
    case Op::kVessel:
      vessel(in);
      break;
    case Op::kBytes: {
      const unsigned flags = in.byte();
      const std::size_t where = (flags & 3U) % boat_->links(), length = in.byte();
      talkers_->bytes(in.take(length), (flags & 0x80U) != 0, now_us_, where);
      if ((flags & 4U) != 0) boat_->end_of_datagram(now_us_, where);
      break;
    }
    case Op::kMessage: {
      const std::uint8_t who = in.byte();
      const std::size_t where = link();
      talkers_->tell(who, any_message(in), now_us_, where);
      break;
    }
    case Op::kCommand:
      any_command(in);
      break;
    case Op::kParameter:
      talkers_->tell(Talkers<S>::kOperator, any_parameter(in, boat_->boat().self()), now_us_);
      break;
    case Op::kFrame:
      push(any_frame(in));
      break;
    case Op::kTransfer:
      any_transfer(in, static_cast<std::uint8_t>(setup_.parameters.CAN_NODE), push);
      break;
    case Op::kEsc:
      esc(in);
      break;
    case Op::kHost:
      host(in);
      break;
    case Op::kClock:
      clock_us_ += std::int64_t{in.number<std::int32_t>()} * 1000;
      break;
    case Op::kRestart: {
      setup_.parameters = boat_->boat().parameters();
      start();
      break;
    }
    case Op::kLink:
      sign_ = (in.byte() & 1U) != 0;
      talkers_->sign(sign_);
      boat_->limit_link(link(), in.number<std::uint16_t>());
      break;
    case Op::kPlan:
      plan(in);
      break;
    case Op::kCount:
      break;
  }
}

template <class S>
void History<S>::ask(std::uint8_t what) {
  namespace mav = link::mav;
  const auto command = [&](std::uint16_t number, std::array<float, 7> param) {
    talkers_->tell(Talkers<S>::kOperator, link::CommandLong{number, param, boat_->boat().self(), 0},
                   now_us_);
  };
  const auto mode = [&](std::uint8_t number) { command(mav::kCmdDoSetMode, {1, float(number)}); };
  switch (what % 14) {
    case 0:
      return command(mav::kCmdComponentArmDisarm, {1});
    case 1:
      return command(mav::kCmdDoSetMode, {1, app::mode::kFormation});
    case 2:
      return command(mav::kCmdDoSetMode, {1, app::mode::kManual});
    case 3:
      return command(mav::kCmdDoSetMode, {1, app::mode::kHold});
    case 4:
      return command(mav::kCmdComponentArmDisarm, {0});
    case 5:
      return command(mav::kCmdDoMotorTest, {1, 0, 20, 1});
    case 6:
      return command(mav::kCmdDoMotorTest, {2, 0, -20, 5});
    case 7:
      return command(mav::kCmdDoFlightTermination, {1});
    case 8:
      return mode(app::mode::kAuto);
    case 9:
      return mode(app::mode::kGuided);
    case 10:
      return mode(app::mode::kLoiter);
    case 11:
      return mode(app::mode::kReturn);
    case 12: {
      link::CommandInt there{};
      there.command = mav::kCmdDoReposition;
      there.param = {-1, 1};
      there.x = own_.origin.latitude + 1500;  // about so many centimetres
      there.y = own_.origin.longitude + 800;
      there.target = boat_->boat().self();
      there.frame = 6;
      return talkers_->tell(Talkers<S>::kOperator, there, now_us_);
    }
    default:
      // The host's disarm is on no link. After noise on a link, no rule reports an unrequested
      // action.
      talkers_->bytes(std::array<std::uint8_t, 1>{}, false, now_us_, 0);
      boat_->disarm();
  }
}

template <class S>
void History<S>::any_command(Stream& in) {
  const std::uint8_t which = in.byte();
  const std::uint8_t flags = in.byte();
  link::CommandLong command{
      which == 255 ? in.number<std::uint16_t>() : kCommands[which % kCommands.size()],
      {},
      boat_->boat().self(),
      static_cast<std::uint8_t>(flags & 1U)};
  for (float& x : command.param) x = any_param(in);
  talkers_->tell((flags & 2U) != 0 ? in.byte() : std::uint8_t{Talkers<S>::kOperator}, command,
                 now_us_, (flags >> 2U) % boat_->links());
}

template <class S>
void History<S>::plan(Stream& in) {
  const link::Address boat = boat_->boat().self();
  const unsigned how = in.byte();
  const auto count = static_cast<std::uint16_t>(how % 16U);
  const auto kind = static_cast<std::uint8_t>(how / 16U % 4U);  // 3: there is none
  link::MissionCount opening{};
  opening.count = count;
  opening.mission_type = kind;
  opening.target = boat;
  talkers_->tell(Talkers<S>::kOperator, opening, now_us_);
  for (std::uint16_t seq = 0; seq < count; ++seq) {
    link::MissionItemInt item{};
    item.target = boat;
    item.seq = seq;
    item.mission_type = kind;
    item.command = kItems[in.byte() % kItems.size()];
    item.param[0] = any_param(in);
    item.param[1] = any_param(in);
    item.x = own_.origin.latitude + in.number<std::int8_t>() * 100;  // about a metre each
    item.y = own_.origin.longitude + in.number<std::int8_t>() * 100;
    talkers_->tell(Talkers<S>::kOperator, item, now_us_);
  }
}

template <class S>
void History<S>::vessel(Stream& in) {
  const std::uint8_t what = in.byte();
  Vessel& vessel = (what & 1U) != 0 ? leader_ : (what & 2U) != 0 ? other_ : own_;
  if ((what & 4U) != 0) {
    vessel.source = in.byte();
    vessel.clock_us += std::int64_t{in.number<std::int32_t>()} * 1000;
  } else if ((what & 8U) != 0) {
    vessel.origin.latitude = in.number<std::int32_t>();
    vessel.origin.longitude = in.number<std::int32_t>();
  } else {
    vessel.north_m += 0.05 * in.number<std::int16_t>();
    vessel.east_m += 0.05 * in.number<std::int16_t>();
    vessel.psi = in.number<std::int8_t>() / 40.0;
    vessel.u = in.number<std::int8_t>() / 32.0;
    vessel.r = in.number<std::int8_t>() / 128.0;
  }
}

template <class S>
void History<S>::esc(Stream& in) {
  const std::uint8_t what = in.byte();
  link::EscStatus& esc = escs_[what & 1U];
  esc.voltage = in.byte() / 8.0F;
  esc.rpm = in.number<std::int16_t>();
  node_.health = what >> 1U & 3U;
  node_.mode = what >> 3U & 7U;
}

template <class S>
void History<S>::host(Stream& in) {
  const std::uint8_t what = in.byte();
  host_.bus_up = (what & 1U) == 0;
  host_.why_not_to_arm = (what & 2U) == 0 ? "" : app::kParametersUnsaved;
  host_.save_failed = (what & 4U) != 0;
  if ((what & 8U) != 0) ++host_.overruns;
  // Signatures' timestamps end soon after the year 2100.
  if ((what & 16U) != 0) host_.unix_us = in.number<std::int64_t>() % 4'100'000'000'000'000;
  boat_->on_host(host_);
}

template <class S>
void History<S>::tell(Talkers<S>& talkers, std::uint8_t who, const Vessel& vessel) {
  vessel.tell(now_us_, [&](const link::Message& m) { talkers.tell(who, m, now_us_); });
  if (now_us_ >= second_due_us_) talkers.tell(who, vessel.origin, now_us_);
}

/// The answer of a sender that hears the boat's TIMESYNC request.
template <class S>
void History<S>::answer_time(const link::Timesync& request) {
  const auto answer = [&](std::uint8_t who, const Vessel& vessel) {
    talkers_->tell(
        who, link::Timesync{(now_us_ + vessel.clock_us) * 1000, request.ts1, boat_->boat().self()},
        now_us_);
  };
  if ((talk_ & kTalkNavigation) != 0) answer(Talkers<S>::kNavigation, own_);
  if ((talk_ & kTalkLeader) != 0) answer(Talkers<S>::kLeader, leader_);
}

template <class S>
void History<S>::talk() {
  if (const auto request = boat_->take_time_request()) answer_time(*request);
  using T = Talkers<S>;
  constexpr std::uint8_t kOther = 5, kImpostor = 7;
  T& t = *talkers_;
  if ((talk_ & kTalkNavigation) != 0) tell(t, T::kNavigation, own_);
  if ((talk_ & kTalkLeader) != 0) tell(t, T::kLeader, leader_);
  if ((talk_ & kTalkOther) != 0) tell(t, kOther, other_);
  if ((talk_ & kTalkImpostor) != 0) tell(t, kImpostor, other_);
  if ((talk_ & kTalkSticks) != 0) {
    sticks_.target = boat_->boat().self().system;
    t.tell(T::kOperator, sticks_, now_us_);
  }
  if ((talk_ & kTalkOperator) != 0 && now_us_ >= second_due_us_) {
    t.tell(T::kOperator,
           link::Heartbeat{0, link::mav::kTypeGcs, link::mav::kAutopilotInvalid, 0, 4}, now_us_);
  }
  if (now_us_ >= second_due_us_) second_due_us_ = now_us_ + kSecond_us;
  if (now_us_ >= escs_due_us_) talk_bus();
}

template <class S>
void History<S>::talk_bus() {
  escs_due_us_ = now_us_ + kEscs_us;
  const app::Parameters& p = boat_->boat().parameters();
  const auto push = [&](const link::CanFrame& frame) { boat_->on_can(frame, now_us_); };
  escs_[0].esc_index = static_cast<std::uint8_t>(p.ESC_PORT);
  escs_[1].esc_index = static_cast<std::uint8_t>(p.ESC_STBD);
  for (unsigned i = 0; i < 2; ++i) {
    if ((talk_ & (i == 0 ? kTalkPort : kTalkStbd)) == 0) continue;
    const auto node = static_cast<std::uint8_t>(126 - i);
    message(node, transfer_id_, escs_[i], push);
    message(node, transfer_id_, node_, push);
  }
  ++transfer_id_;
}

template <class S>
void History<S>::tick() {
  ++ticks_;
  now_us_ += step_us_;
  const double dt = static_cast<double>(step_us_) * 1e-6;
  const app::Parameters& p = boat_->boat().parameters();
  own_.push(p, thrust_N_, dt);
  own_.go(dt);
  leader_.go(dt);
  other_.go(dt);
  talk();
  const link::RawCommand& told = boat_->tick(now_us_ + clock_us_);
  const auto thrust_N = [&](float index, float direction) {
    return told.cmd[static_cast<std::size_t>(index)] / 8191.0 * double{p.THR_FWD_MAX * direction};
  };
  thrust_N_ = {thrust_N(p.ESC_PORT, p.THR_PORT_DIR), thrust_N(p.ESC_STBD, p.THR_STBD_DIR)};
  states_reached |= core::in(boat_->boat().state());
  if (boat_->boat().stored_id(app::Stored::kFence) != 0) {
    states_fenced |= core::in(boat_->boat().state());
  }
}

}  // namespace flotilla::fuzz

namespace {

void print_states(const char* title, unsigned states) {
  std::fprintf(stderr, "%s:", title);
  for (unsigned i = 0; i < flotilla::core::kStates; ++i) {
    if ((states >> i & 1U) == 0) continue;
    const auto name = flotilla::app::name_of(static_cast<flotilla::core::State>(i));
    std::fprintf(stderr, " %.*s", static_cast<int>(name.size()), name.data());
  }
  std::fprintf(stderr, "\n");
}

void print_all() {
  print_states("states reached", flotilla::fuzz::states_reached);
  print_states("with a fence", flotilla::fuzz::states_fenced);
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) { return std::atexit(print_all); }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return flotilla::fuzz::play<flotilla::fuzz::History>(data, size);
}
