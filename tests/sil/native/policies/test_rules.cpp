// SPDX-License-Identifier: MIT
// Every rule holds for good pairs of ticks, and one pair breaks each rule.
#include <doctest/doctest.h>

#include <algorithm>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "policies/monitor.hpp"
#include "policies/rules.hpp"

namespace flotilla::policies {
namespace {

using core::State;
namespace mav = link::mav;

/// Two ticks of a boat, 10 ms apart, long after it entered that state; all senders were heard just
/// now.
struct Pair {
  app::Parameters p{};
  Moment b, n;

  explicit Pair(State state) {
    for (Moment* m : {&b, &n}) set(*m, state, m == &b ? 9'990'000 : 10'000'000);
  }
  Pair(const Pair&) = delete;

  void set(Moment& m, State state, std::int64_t now_us) {
    m.now_us = m.own_us = m.leader_us = m.sticks_us = m.neutral_us = now_us;
    m.own_true_us = m.leader_true_us = now_us - 50'000;
    m.clocks = {0, -7'000'000};
    m.dt_us = 10'000;
    m.esc_us = {now_us, now_us};
    m.arming_us = m.status_us = m.beat_us = m.timesync_us = now_us - 50'000;
    m.state = state;
    m.state_us = m.armed_us = now_us - 1'000'000;
    m.met =
        state == State::kCoast ? core::kAllConditions & ~core::kLeaderFresh : core::kAllConditions;
    m.own_age_s = 0.05;
    m.leader_age_s = 0.1;
    m.p = &p;
    m.heard.own = m.heard.leader = true;
    m.arming = core::armed(state) ? 255 : 0;
    m.bus.commands = m.bus.frames = 1;
    m.bus.size = 2;
    if (core::law_drives(state) || state == State::kManual) {
      m.port = m.bus.loudest = 1000;
      m.thrust_N.port = 2;
    }
    m.links.beats = true;
    m.links.mode = rules::mode_of(state);
    m.links.flags = core::armed(state) ? 128 : 0;
    m.links.status = state == State::kCoast   ? mav::kStateCritical
                     : state == State::kFault ? mav::kStateEmergency
                                              : mav::kStateActive;
    m.links.states_word = true;
    m.links.gravest = mav::kSeverityError;
  }
};

struct Mutation {
  std::string_view rule;
  State state;
  std::function<void(Pair&)> change;
};

/// Puts the tick before into another state, so that the present state has just begun.
auto from(State before, std::function<void(Pair&)> change = [](Pair&) {}) {
  return [before, change](Pair& q) {
    const Moment now = q.n;
    q.set(q.b, before, q.b.now_us);
    q.n = now;
    q.n.state_us = now.now_us;
    if (core::armed(now.state) && !core::armed(before)) {
      q.n.armed_us = now.now_us;
      q.n.port = q.n.bus.loudest = 0;
      q.n.thrust_N = {};
    }
    if (core::armed(now.state) != core::armed(before)) q.n.bus.armings = 1;
    change(q);
  };
}

auto lost(core::Conditions bits) {
  return [bits](Pair& q) { q.n.met &= ~bits; };
}
auto done(Ask what) {
  return [what](Pair& q) { ++q.n.done[what]; };
}
void push(Pair& q) { q.n.port = q.n.bus.loudest = 100, q.n.thrust_N.port = 0.2F; }

constexpr State kGuided = State::kGuided, kLoiter = State::kLoiter, kReturn = State::kReturn;
constexpr State kOff = State::kDisarmed, kHold = State::kHold, kLaw = State::kFormation,
                kManual = State::kManual, kCoast = State::kCoast, kTest = State::kTest,
                kFault = State::kFault;

const std::vector<Mutation> kThrust{
    {"DISARMED: commands are zero within a tick", kOff, push},
    {"HOLD: zeros within a tick", kHold, push},
    {"FAULT: zeros within a tick", kFault, push},
    {"no thrust in the first 0.2 s after arming", kLaw,
     [](Pair& q) { q.n.armed_us = q.n.now_us - 199'000; }},
    {"ESCs rebooted: zeros for 0.2 s before thrust", kLaw,
     [](Pair& q) { q.n.reboot_us = q.n.now_us - 199'000; }},
    {"no thrust before ArmingStatus 255 was sent", kLaw, [](Pair& q) { q.n.arming = 0; }},
    {"another controller on the bus: zeros for 2 s", kLaw,
     [](Pair& q) { q.n.controller_us = q.n.now_us - 1'990'000; }},
    {"port ESC silent for FS_ESC_S: no thrust", kLaw, [](Pair& q) { q.n.esc_us[0] -= 1'210'000; }},
    {"starboard ESC silent for FS_ESC_S: no thrust", kLaw,
     [](Pair& q) { q.n.esc_us[1] -= 1'210'000; }},
    {"an ESC offline or not healthy: no thrust", kLaw, lost(core::kEscsOnline)},
    {"CAN bus down: no thrust", kLaw, lost(core::kBusUp)},
    {"an ESC does not obey: no thrust", kLaw, lost(core::kEscsObey)},
    {"sticks silent for 0.5 s: no thrust in MANUAL", kManual,
     [](Pair& q) { q.n.sticks_us -= 510'000; }},
    {"own state older than FS_NAV_S: no thrust by the law", kLaw,
     [](Pair& q) { q.n.own_age_s = 0.5; }},
    {"own system silent for FS_NAV_S: no thrust by the law", kCoast,
     [](Pair& q) { q.n.own_us -= 510'000; }},
    {"leader's state older than FS_LEADER_S: no thrust in FORMATION", kLaw,
     [](Pair& q) { q.n.leader_age_s.reset(); }},
    {"leader silent for FS_LEADER_S: no thrust in FORMATION", kLaw,
     [](Pair& q) { q.n.leader_us -= 1'010'000; }},
    {"true age of own state over FS_NAV_S: no thrust by the law", kCoast,
     [](Pair& q) { q.n.own_true_us -= 460'000; }},
    {"true age of leader's state over FS_LEADER_S: no thrust in FORMATION", kLaw,
     [](Pair& q) { q.n.leader_true_us -= 960'000; }},
    {"MANUAL: no thrust before the sticks were at neutral", kManual,
     [](Pair& q) { q.n.neutral_us = q.n.state_us - 510'000; }},
    {"age of own state unknown: no thrust by the law", kCoast, lost(core::kOwnTimed)},
    {"navigation unit reports a poor estimate: no thrust by the law", kCoast, lost(core::kOwnGood)},
    {"own state frozen or jumping: no thrust by the law", kLaw, lost(core::kOwnLive)},
    {"leader's state frozen, jumping or of unknown age: no thrust in FORMATION", kLaw,
     lost(core::kLeaderSteady)},
    {"leader's state frozen, jumping or of unknown age: no thrust in FORMATION", kLaw,
     lost(core::kLeaderTimed)},
    {"leader beyond FORM_DIST_MAX: no thrust in FORMATION", kLaw, lost(core::kLeaderNear)},
    {"navigation unit too late: no thrust by the law", kLaw, lost(core::kOwnPrompt)},
    {"leaders form a cycle, or the slot is not valid: no thrust in FORMATION and COAST", kLaw,
     lost(core::kSlotSound)},
    {"boat does not keep its slot: no thrust in FORMATION", kLaw, lost(core::kOnStation)},
    {"boat does not respond to thrust: no thrust by the law", kCoast, lost(core::kBoatAnswers)},
    {"battery low: no thrust by the law except in LOITER and RTL", kLaw, lost(core::kBatteryGood)},
    {"beyond the fence: no thrust by the law except in LOITER and RTL", kGuided,
     lost(core::kInsideFence)},
    {"home unknown or far: no thrust in RTL", kReturn, lost(core::kHomeNear)},
    {"no ground station where one is required: no thrust in FORMATION", kLaw,
     lost(core::kGcsHeard)},
    {"FS_COAST_S is over: no thrust in COAST", kCoast, lost(core::kCoastRunning)},
    {"thrust never rises in COAST", kCoast, [](Pair& q) { q.n.thrust_N.stbd = -2.1F; }},
    {"thrust never exceeds the limits of the propellers", kLaw,
     [](Pair& q) { q.n.thrust_N.stbd = -20.1F; }},
    {"TEST commands at most a fifth of the greatest thrust", kTest,
     [](Pair& q) { q.n.thrust_N.port = 4.1F; }},
    {"TEST turns one propeller only", kTest, [](Pair& q) { q.n.port = q.n.stbd = 1; }},
};

const std::vector<Mutation> kBus{
    {"RawCommand is never beyond ±8191", kLaw, [](Pair& q) { q.n.bus.loudest = 8192; }},
    {"one RawCommand in every tick", kHold, [](Pair& q) { q.n.bus.commands = 2; }},
    {"RawCommand names both propellers' ESCs", kHold, [](Pair& q) { q.p.ESC_STBD = 2; }},
    {"no other ESC is ever commanded to turn", kLaw,
     [](Pair& q) { q.n.bus.strangers_idle = false; }},
    {"each propeller's command stands at its ESC's index", kLaw,
     [](Pair& q) { std::swap(q.n.port, q.n.stbd); }},
    {"a command changes at most by THR_SLEW, except to zero", kLaw,
     [](Pair& q) { q.n.port = 1412; }},
    {"ArmingStatus is 0 or 255", kHold, [](Pair& q) { q.n.arming = 254; }},
    {"ArmingStatus 255 only while armed", kOff,
     [](Pair& q) { q.n.bus.armings = 1, q.n.arming = 255; }},
    {"ArmingStatus 0 only while not armed", kHold,
     [](Pair& q) { q.n.bus.armings = 1, q.n.arming = 0; }},
    {"disarmed or in FAULT: ArmingStatus 0 in the same tick", kOff,
     from(kHold, [](Pair& q) { q.n.bus.armings = 0; })},
    {"armed: ArmingStatus 255 before the tick's command", kHold,
     from(kOff, [](Pair& q) { q.n.bus.told_before = false; })},
    {"ArmingStatus is sent at least every 0.11 s", kHold, [](Pair& q) { q.n.arming_us -= 61'000; }},
    {"NodeStatus is sent at least every 1.1 s", kHold, [](Pair& q) { q.n.status_us -= 1'051'000; }},
    {"NodeStatus reports OK and operational", kOff, [](Pair& q) { q.n.health = 1; }},
    {"a node's uptime never runs backwards", kOff, [](Pair& q) { q.b.uptime_s = 1; }},
    {"every transfer is complete and its checksum correct", kOff,
     [](Pair& q) { q.n.bus.whole = false; }},
    {"every frame is from CAN_NODE", kOff, [](Pair& q) { q.n.bus.ours = false; }},
    {"transfer ids increase by one", kOff, [](Pair& q) { q.n.bus.counted = false; }},
    {"at most 64 frames in a tick", kOff, [](Pair& q) { q.n.bus.frames = 65; }},
};

const std::vector<Mutation> kState{
    {"FAULT is left by disarming only", kOff, from(kFault)},
    {"FAULT leads to DISARMED, or to a state requested after disarming", kHold, from(kFault)},
    {"armed only after a command to arm", kHold, from(kOff, done(Ask::kArm))},
    {"no other system than MAV_GCS_SYSID arms the boat", kHold, from(kOff, done(Ask::kArmAllowed))},
    {"MANUAL only after a request, or after FORMATION was lost", kManual,
     from(kHold, done(Ask::kManual))},
    {"FORMATION only after a request, or after COAST", kLaw, from(kHold, done(Ask::kFormation))},
    {"AUTO only after a request, or by a fleet's rule", State::kAuto,
     from(kHold, done(Ask::kAuto))},
    {"GUIDED only after a request", kGuided, from(kHold, done(Ask::kGuided))},
    {"LOITER only after a request, or after a loss", kLoiter, from(kHold, done(Ask::kLoiter))},
    {"RTL only after a request, or after a loss", kReturn, from(kHold, done(Ask::kReturn))},
    {"TEST only after a command for a motor test", kTest, from(kHold, done(Ask::kTest))},
    {"DISARMED leads to FAULT only by termination or a stop switch", kFault,
     from(kOff, done(Ask::kTerminate))},
    {"a command to disarm is obeyed in the next tick", kHold,
     [](Pair& q) { q.n.heard.stop = true; }},
    {"the boat arms only if all conditions for arming are met", kHold,
     from(kOff, lost(core::kParametersSaved))},
    {"armed only while the propellers are ready and the numbers in range", kHold,
     lost(core::kSoleController)},
    {"armed only while the propellers are ready and the numbers in range", kHold,
     lost(core::kInRange)},
    {"MANUAL only while sticks are fresh", kManual, lost(core::kSticksFresh)},
    {"FORMATION only while its conditions are met", kLaw, lost(core::kLeaderLive)},
    {"FORMATION begins only if no vessel is within FS_SEP_M", kLaw,
     from(kHold, lost(core::kClear))},
    {"AUTO only while its conditions are met", State::kAuto, lost(core::kPlanReady)},
    {"AUTO only while its conditions are met", State::kAuto, lost(core::kOnStation)},
    {"AUTO only while its conditions are met", State::kAuto, lost(core::kGcsHeard)},
    {"AUTO begins only if no vessel is within FS_SEP_M", State::kAuto,
     from(kHold, lost(core::kClear))},
    {"GUIDED only while its conditions are met", kGuided, lost(core::kInsideFence)},
    {"GUIDED begins only if no vessel is within FS_SEP_M", kGuided,
     from(kHold, lost(core::kClear))},
    {"LOITER only while its conditions are met", kLoiter, lost(core::kLocated)},
    {"RTL only while its conditions are met", kReturn, lost(core::kHomeNear)},
    {"COAST only while its conditions are met", kCoast, lost(core::kOwnSteady)},
    {"COAST begins in FORMATION only", kCoast, from(kHold)},
    {"COAST begins in FORMATION only", kCoast, from(State::kAuto)},
    {"COAST begins only if the leader, the slot or the ground station is lost", kCoast,
     from(kLaw, [](Pair& q) { q.n.met = core::kAllConditions; })},
    {"COAST ends within FS_COAST_S", kCoast, [](Pair& q) { q.n.state_us -= 4'011'000; }},
    {"TEST ends within 5 s", kTest, [](Pair& q) { q.n.state_us -= 4'011'000; }},
};

const std::vector<Mutation> kMavlink{
    {"HEARTBEAT is sent at least every 1.1 s", kHold, [](Pair& q) { q.n.beat_us -= 1'051'000; }},
    {"HEARTBEAT's mode matches the state", kLaw, [](Pair& q) { q.n.links.mode = 4; }},
    {"HEARTBEAT's armed flag matches the state", kHold, [](Pair& q) { q.n.links.flags = 0; }},
    {"HEARTBEAT's status is CRITICAL exactly in COAST", kCoast,
     [](Pair& q) { q.n.links.status = mav::kStateActive; }},
    {"HEARTBEAT's status is EMERGENCY exactly in FAULT", kFault,
     [](Pair& q) { q.n.links.status = mav::kStateStandby; }},
    {"a change of state sends HEARTBEAT on every link in the same tick", kHold,
     from(kOff, [](Pair& q) { q.n.links.beats = false; })},
    {"a change of state sends a text with its name in the same tick", kHold,
     from(kOff, [](Pair& q) { q.n.links.states_word = false; })},
    {"FAULT is reported at ERROR or worse", kFault,
     from(kHold, [](Pair& q) { q.n.links.gravest = mav::kSeverityInfo; })},
    {"TIMESYNC is requested at least every 1.1 s, or as often as slow telemetry", kHold,
     [](Pair& q) { q.n.timesync_us -= 1'051'000; }},
    {"TIMESYNC is requested at least every 1.1 s, or as often as slow telemetry", kHold,
     [](Pair& q) { q.p.SR_SLOW = 0.2F, q.n.timesync_us -= 5'051'000; }},
    {"messages carry our system id, or are forwarded", kOff,
     [](Pair& q) { q.n.links.ours = false; }},
    {"forwarded messages precede ours", kOff, [](Pair& q) { q.n.links.others_first = false; }},
    {"sequence numbers increase by one", kOff, [](Pair& q) { q.n.links.counted = false; }},
    {"output consists of whole messages", kOff, [](Pair& q) { q.n.links.whole = false; }},
    {"at most 1400 bytes on a link in a tick", kOff, [](Pair& q) { q.n.links.longest = 1401; }},
    {"no NaN is sent", kOff, [](Pair& q) { q.n.links.finite = false; }},
    {"time in telemetry is the boat's", kOff, [](Pair& q) { q.n.links.punctual = false; }},
    {"position is sent only while own state is fresh", kOff,
     [](Pair& q) {
       q.n.links.places = true;
       q.b.met &= ~core::kOwnFresh;
       q.n.met &= ~core::kOwnFresh;
     }},
    {"no answer without a command", kOff, done(Ask::kAck)},
};

const std::vector<Mutation> kInside{
    {"a foreign system id never moves the leader's track", kOff,
     [](Pair& q) { q.n.heard.leader = false; }},
    {"a foreign system id never moves the own track", kOff,
     [](Pair& q) { q.n.heard.own = false, q.b.own_age_s.reset(); }},
    {"parameters that need a disarmed boat do not change while armed", kHold,
     [](Pair& q) { q.n.locked_change = true; }},
    {"parameters are always in their ranges", kOff, [](Pair& q) { q.n.in_range = false; }},
    {"the boat's time never runs backwards", kOff, [](Pair& q) { q.b.now_us = q.n.now_us + 1; }},
    {"thrusts are never NaN", kLaw, [](Pair& q) { q.n.thrust_N.stbd = std::nanf(""); }},
};

std::vector<Mutation> all() {
  std::vector<Mutation> out;
  for (const auto* some : {&kThrust, &kBus, &kState, &kMavlink, &kInside}) {
    out.insert(out.end(), some->begin(), some->end());
  }
  return out;
}

const Rule* rule_of(std::string_view name) {
  const auto* const found = std::ranges::find(kRules, name, &Rule::name);
  return found == kRules.end() ? nullptr : found;
}

TEST_CASE("no two rules have the same name, and there are at least sixty") {
  std::set<std::string_view> names;
  for (const Rule& rule : kRules) CHECK(names.insert(rule.name).second);
  CHECK(names.size() >= 60);
}

TEST_CASE("a boat that stays in a state breaks no rule") {
  for (const State s :
       {kOff, kHold, kManual, kLaw, kCoast, kTest, kFault, kGuided, kLoiter, kReturn}) {
    const Pair q(s);
    CHECK_MESSAGE(first_broken(q.b, q.n).value_or("") == "", static_cast<int>(s));
  }
}

TEST_CASE("a boat with an SR_SLOW of 0.2 may ask by TIMESYNC every 5 s") {
  Pair q(kHold);
  q.n.timesync_us -= 5'000'000;
  CHECK(first_broken(q.b, q.n));
  q.p.SR_SLOW = 0.2F;
  CHECK(!first_broken(q.b, q.n));
}

TEST_CASE("a boat that goes from a state to another one breaks no rule") {
  constexpr State kAuto = State::kAuto;
  const std::vector<std::pair<State, State>> ways{
      {kOff, kHold},  {kHold, kLaw},    {kLaw, kCoast},   {kCoast, kLaw},  {kLaw, kHold},
      {kHold, kTest}, {kHold, kManual}, {kHold, kFault},  {kHold, kAuto},  {kLaw, kAuto},
      {kAuto, kHold}, {kAuto, kLaw},    {kHold, kGuided}, {kLaw, kLoiter}, {kAuto, kReturn}};
  for (const auto& [before, now] : ways) {
    Pair q(now);
    from(before)(q);
    CHECK_MESSAGE(first_broken(q.b, q.n).value_or("") == "", static_cast<int>(now));
  }
}

TEST_CASE("every rule can be broken") {
  std::set<std::string_view> broken;
  for (const Mutation& m : all()) {
    const Rule* rule = rule_of(m.rule);
    REQUIRE_MESSAGE(rule != nullptr, std::string(m.rule));
    Pair q(m.state);
    m.change(q);
    CHECK_MESSAGE(!rule->holds(q.b, q.n), std::string(m.rule));
    CHECK(first_broken(q.b, q.n));
    broken.insert(m.rule);
  }
  for (const Rule& rule : kRules) CHECK_MESSAGE(broken.contains(rule.name), std::string(rule.name));
}

TEST_CASE("after torn bytes, no rule reports an unrequested action") {
  for (const Ask what :
       {Ask::kArm, Ask::kManual, Ask::kFormation, Ask::kAuto, Ask::kTest, Ask::kAck}) {
    Pair q(kHold);
    ++q.n.done[what];
    CHECK(first_broken(q.b, q.n));
    q.n.torn = true;
    CHECK(!first_broken(q.b, q.n));
  }
}

}  // namespace
}  // namespace flotilla::policies
