// SPDX-License-Identifier: MIT
// Every history of the shipped table, searched state by state. A model of ESCs, links, sea and
// operator allows any number of events between two ticks, in any order.
#include <doctest/doctest.h>

#include <array>
#include <utility>
#include <vector>

#include "core/supervisor.hpp"

namespace flotilla::core {
namespace {

enum class Esc : unsigned { kOnline, kOffline, kDisobeys, kReboots };

/// The supervisor and its surroundings. A flag is set if something is wrong.
struct Node {
  State state = State::kDisarmed;
  Esc esc = Esc::kOnline;
  unsigned wrong = 0;   ///< of kTroubles, a bit each
  unsigned coast = 0;   ///< ticks that COAST still lasts
  unsigned test = 0;    ///< ticks that the motor test still lasts
  bool full = false;    ///< the sticks, now
  bool centred = true;  ///< the sticks, once since MANUAL began
};

constexpr std::array<Conditions, 11> kTroubles{kOwnFresh | kOwnSteady,
                                               kLeaderFresh | kLeaderTimed | kLeaderNear | kPlace,
                                               kSoleController | kBusUp | kInRange,
                                               kGcsHeard,
                                               kLimits,
                                               kSticksFresh,
                                               kBoatAnswers | kOwnPrompt | kOwnTimed | kOwnGood,
                                               kClear,
                                               kParametersSaved | kSoleVessel | kGainsFit,
                                               kPlanReady | kOnStation,
                                               kHomeNear | kLocated};
/// The troubles that prevent neither arming nor driving by the sticks.
constexpr unsigned kHarmless = 0b11'011'010'011;
constexpr unsigned kSticks = 0b00'000'100'000, kUnsaved = 0b00'100'000'000;
constexpr unsigned kLeaderAway = 0b00'000'000'010, kNoHome = 0b10'000'000'000;
constexpr unsigned kCoastTicks = 3, kTestTicks = 2;
constexpr unsigned kCodeBits = 4 + 2 + kTroubles.size() + 2 + 2 + 2;

unsigned code_of(const Node& n) {
  unsigned code = static_cast<unsigned>(n.state);
  code = code << 2U | static_cast<unsigned>(n.esc);
  code = code << kTroubles.size() | n.wrong;
  code = (code << 2U | n.coast) << 2U | n.test;
  return (code << 1U | (n.full ? 1U : 0U)) << 1U | (n.centred ? 1U : 0U);
}

Conditions conditions_of(const Node& n) {
  Conditions met = kAllConditions;
  for (std::size_t i = 0; i < kTroubles.size(); ++i) {
    if ((n.wrong >> i & 1U) != 0) met &= ~kTroubles[i];
  }
  if (n.esc == Esc::kOffline || n.esc == Esc::kReboots) met &= ~kEscsOnline;
  if (n.esc == Esc::kDisobeys) met &= ~kEscsObey;
  if (n.state == State::kCoast && n.coast == 0) met &= ~kCoastRunning;
  if (n.test == 0) met &= ~kTestRunning;
  if (!n.centred) met &= ~kSticksCentred;
  return met;
}

void enter(Node& n, State state) {
  if (state == State::kCoast && n.state != State::kCoast) n.coast = kCoastTicks;
  if (state != State::kCoast) n.coast = 0;
  if (state != State::kTest) n.test = 0;
  if (state != n.state) n.centred = !n.full;
  n.state = state;
}

/// The first half of a tick of the boat: the automatic transitions.
Node forced(Node n, const Choices& choices) {
  n.centred = !n.full || (n.centred && n.state == State::kManual);
  const Conditions met = conditions_of(n);
  enter(n, supervise(n.state, Request::kNone, met, response_to(choices, n.state, met)).state);
  return n;
}

struct Tick {
  Node after;
  bool pushes = false;
};

/// The second half: the request, and the tick's time.
Tick answered(Node n, Request request) {
  Node asked = n;
  if (request == Request::kTest && n.test == 0) asked.test = kTestTicks;
  const Verdict verdict = supervise(n.state, request, conditions_of(asked));
  if (request != Request::kNone && verdict.granted) {
    n.test = asked.test;
    enter(n, verdict.state);
  }
  const bool pushes = may_drive(n.state, conditions_of(n));
  if (n.coast > 0) --n.coast;
  if (n.test > 0) --n.test;
  return {n, pushes};
}

Tick tick_of(const Node& n, Request request, const Choices& choices) {
  return answered(forced(n, choices), request);
}

/// The possible events between two ticks, one at a time.
std::vector<Node> events_of(const Node& n) {
  std::vector<Node> out;
  for (std::size_t i = 0; i < kTroubles.size(); ++i) {
    out.push_back(n);
    out.back().wrong ^= 1U << i;
  }
  out.push_back(n);
  out.back().full = !n.full;
  for (const Esc esc : {Esc::kOnline, Esc::kOffline, Esc::kDisobeys, Esc::kReboots}) {
    // An ESC that reboots is silent for a while before it is back.
    if (n.esc == Esc::kReboots && esc != Esc::kOffline) continue;
    out.push_back(n);
    out.back().esc = esc;
  }
  return out;
}

/// Calls f(before, request, tick) for every tick of every history of a boat that is switched on
/// without troubles; returns the number of nodes.
template <class F>
std::size_t search(const Choices& choices, F f) {
  std::vector<bool> seen(std::size_t{1} << kCodeBits);
  std::vector<Node> open;
  const auto visit = [&](const Node& n) {
    if (seen[code_of(n)]) return;
    seen[code_of(n)] = true;
    open.push_back(n);
  };
  visit(Node{});
  std::size_t nodes = 0;
  for (; !open.empty(); ++nodes) {
    const Node n = open.back();
    open.pop_back();
    for (const Node& next : events_of(n)) visit(next);
    const Node halfway = forced(n, choices);
    for (unsigned r = 0; r < kRequests; ++r) {
      const auto request = static_cast<Request>(r);
      const Tick tick = answered(halfway, request);
      f(n, request, tick);
      visit(tick.after);
    }
  }
  return nodes;
}

/// Choices with different effects; test_supervisor.cpp has all of their combinations.
template <class F>
void for_some_choices(F f) {
  using enum Reaction;
  for (const Choices& choices :
       {Choices{kHold, kHold, kHold, kHold, kHold}, Choices{kCoast, kHold, kHold, kReturn, kHold},
        Choices{kCoast, kCoast, kReturn, kLoiter, kLoiter},
        Choices{kManual, kManual, kLoiter, kHold, kReturn},
        Choices{kLoiter, kReturn, kReturn, kReturn, kReturn},
        Choices{kReturn, kLoiter, kLoiter, kLoiter, kLoiter},
        Choices{kManual, kCoast, kReturn, kReturn, kReturn}}) {
    f(choices);
  }
}

/// Counters of events that must not occur in any tick.
struct Broken {
  int pushed_unarmed = 0, pushed_without_escs = 0, law_pushed_blind = 0, fault_left = 0;
  int armed_without_escs = 0, disarm_refused = 0, terminate_refused = 0, coast_too_long = 0;
  int coast_ended_elsewhere = 0, formation_by_itself = 0, not_back_to_the_start = 0;
  int manual_began_full = 0, formation_unfit = 0, auto_unfit = 0, auto_by_itself = 0, stranded = 0;
  int moved_from_hold = 0, returned_lost = 0;

  bool any() const {
    return pushed_unarmed + pushed_without_escs + law_pushed_blind + fault_left +
               armed_without_escs + disarm_refused + terminate_refused + coast_too_long +
               coast_ended_elsewhere + formation_by_itself + not_back_to_the_start +
               manual_began_full + formation_unfit + auto_unfit + auto_by_itself + stranded +
               moved_from_hold + returned_lost !=
           0;
  }

  void look(const Node& before, Request request, const Tick& tick) {
    const State was = before.state, is = tick.after.state;
    const bool quiet = request == Request::kNone;
    const bool online = before.esc == Esc::kOnline;
    const bool blind = (before.wrong & 1U) != 0;
    pushed_unarmed += tick.pushes && (is == State::kDisarmed || is == State::kFault);
    pushed_without_escs += tick.pushes && !online;
    law_pushed_blind += tick.pushes && law_drives(is) && blind;
    armed_without_escs += armed(is) && !online;
    fault_left += was == State::kFault && is != was && request != Request::kDisarm;
    disarm_refused += request == Request::kDisarm && is != State::kDisarmed;
    terminate_refused += request == Request::kTerminate && is != State::kFault;
    formation_by_itself += quiet && is == State::kFormation && was != is && was != State::kCoast;
    formation_unfit += is == State::kFormation && !law_drives(was) &&
                       (before.wrong & ~(kSticks | kUnsaved | kNoHome)) != 0;
    auto_by_itself += quiet && (is == State::kAuto || is == State::kGuided) && was != is;
    moved_from_hold += quiet && was == State::kHold && law_drives(is);
    returned_lost += tick.pushes && is == State::kReturn && (before.wrong & kNoHome) != 0;
    auto_unfit += is == State::kAuto && !law_drives(was) &&
                  (before.wrong & ~(kSticks | kUnsaved | kLeaderAway)) != 0;
    manual_began_full += tick.pushes && is == State::kManual && was != is && before.full;
    if (was != State::kCoast) return;
    coast_too_long += is == State::kCoast && tick.after.coast + 1 != before.coast;
    const bool well = online && (before.wrong & 0b100U) == 0;
    coast_ended_elsewhere += quiet && well && is != State::kCoast && is != State::kHold &&
                             is != State::kFormation && is != State::kLoiter &&
                             is != State::kReturn;
  }
};

/// One search through all histories; both tests read its findings.
struct Found {
  std::vector<std::pair<Choices, Broken>> broken;
  std::array<unsigned, kStates> next{};  ///< states that each led to in one tick
  unsigned pushing = 0;                  ///< states in which it pushed
  std::size_t nodes = 0;

  Found() {
    for_some_choices([this](const Choices& choices) { look(choices); });
  }

  void look(const Choices& choices) {
    Broken seen;
    nodes += search(choices, [&](const Node& before, Request request, const Tick& tick) {
      next[static_cast<std::size_t>(before.state)] |= in(tick.after.state);
      if (tick.pushes) pushing |= in(tick.after.state);
      seen.look(before, request, tick);
      if (request != Request::kNone) return;  // The rest depends on the node alone.
      // All is repaired and the boat disarmed: as new. So every node leads to every other one.
      const Node repaired{before.state, Esc::kOnline, 0, before.coast, before.test};
      seen.not_back_to_the_start +=
          code_of(tick_of(repaired, Request::kDisarm, choices).after) != code_of(Node{});
      // Only the propellers are repaired: the boat can be driven home from FAULT or any state.
      Node home{before.state, Esc::kOnline, before.wrong & kHarmless, before.coast, before.test};
      for (const Request ask : {Request::kDisarm, Request::kArm}) {
        home = tick_of(home, ask, choices).after;
      }
      seen.stranded += !tick_of(home, Request::kManual, choices).pushes;
    });
    broken.emplace_back(choices, seen);
  }
};

const Found& found() {
  static const Found all;
  return all;
}

TEST_CASE("no sequence of faults and requests leads to a forbidden state") {
  CHECK(found().broken.size() == 7);
  for (const auto& [choices, broken] : found().broken) {
    CAPTURE(static_cast<int>(choices.leader));
    CAPTURE(static_cast<int>(choices.gcs));
    CHECK(broken.pushed_unarmed == 0);
    CHECK(broken.pushed_without_escs == 0);
    CHECK(broken.law_pushed_blind == 0);
    CHECK(broken.armed_without_escs == 0);
    CHECK(broken.fault_left == 0);
    CHECK(broken.disarm_refused == 0);
    CHECK(broken.terminate_refused == 0);
    CHECK(broken.coast_too_long == 0);
    CHECK(broken.coast_ended_elsewhere == 0);
    CHECK(broken.formation_by_itself == 0);
    CHECK(broken.not_back_to_the_start == 0);
    CHECK(broken.manual_began_full == 0);
    CHECK(broken.formation_unfit == 0);
    CHECK(broken.auto_unfit == 0);
    CHECK(broken.auto_by_itself == 0);
    CHECK(broken.stranded == 0);
    CHECK(broken.moved_from_hold == 0);
    CHECK(broken.returned_lost == 0);
    CHECK_FALSE(broken.any());
  }
  MESSAGE(found().nodes, " states visited");
}

TEST_CASE("every state is reached, and each leads in one tick exactly to the states that it may") {
  const auto& next = found().next;
  using enum State;
  constexpr unsigned kStops = in(kDisarmed, kFault);
  constexpr unsigned kDriven =
      kStops | in(kHold, kManual, kFormation, kAuto, kGuided, kLoiter, kReturn);
  CHECK(next[0] == (kStops | in(kHold)));
  CHECK(next[1] == (kDriven | in(kTest)));
  CHECK(next[2] == (kDriven | in(kTest)));  // the sticks are lost, then a test is requested
  CHECK(next[3] == (kDriven | in(kCoast, kTest)));
  CHECK(next[4] == (kDriven | in(kCoast, kTest)));
  CHECK(next[5] == (kDriven | in(kTest)));
  CHECK(next[6] == kStops);
  for (unsigned alone = 7; alone < kStates; ++alone) CHECK(next[alone] == (kDriven | in(kTest)));
  CHECK(found().pushing ==
        in(kManual, kFormation, kCoast, kTest, kAuto, kGuided, kLoiter, kReturn));
}

}  // namespace
}  // namespace flotilla::core
