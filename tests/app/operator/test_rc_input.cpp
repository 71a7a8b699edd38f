// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <array>

#include "app/operator/requests/rc_input.hpp"

namespace flotilla::app {
namespace {

using core::Request, core::State;

constexpr std::uint8_t kSwitch = 7;

struct Transmitter {
  RcInput rc;
  std::array<std::uint16_t, 8> pulses{1500, 1500, 1500, 1500, 1500, 1500, 1000, 1500};

  bool hear(State state) {
    last = state;
    return rc.hear(pulses, kSwitch, state, now_us);
  }
  std::optional<Request> request() { return rc.take_request(last, now_us); }
  State last = State::kDisarmed;
  std::int64_t now_us = 1'000'000;
  void set(std::uint16_t steering, std::uint16_t throttle, std::uint16_t turned) {
    pulses[0] = steering, pulses[2] = throttle, pulses[6] = turned;
  }
};

TEST_CASE("a transmitter at rest gives no sticks and requests nothing") {
  for (const State state : {State::kDisarmed, State::kHold, State::kManual, State::kFormation,
                            State::kCoast, State::kTest, State::kFault}) {
    Transmitter t;
    CHECK(t.hear(state));
    CHECK_FALSE(t.rc.sticks());
    CHECK_FALSE(t.request());
  }
}

TEST_CASE("a receiver counts as lost while its unit reports it enabled but not healthy") {
  constexpr std::uint32_t kBit = link::mav::kSensorRcReceiver;
  RcInput rc;
  CHECK_FALSE(rc.is_lost(140));
  const auto lost = [&rc](std::uint32_t present, std::uint32_t enabled, std::uint32_t health) {
    link::SysStatus status{};
    status.sensors_present = present;
    status.sensors_enabled = enabled;
    status.sensors_health = health;
    rc.judge(140, status);
    CHECK_FALSE(rc.is_lost(141));
    return rc.is_lost(140);
  };
  CHECK_FALSE(lost(~0U, ~0U, ~0U));
  CHECK_FALSE(lost(~0U, ~0U, kBit));
  CHECK(lost(~0U, kBit, ~kBit));
  CHECK(lost(0, 0, 0));
  CHECK_FALSE(lost(kBit, ~kBit, 0));
}

TEST_CASE("only one component's pulses count until it is silent or has lost its transmitter") {
  constexpr std::array<std::uint16_t, 8> kPulses{1500, 1500, 1500, 1500, 1500, 1500, 1900, 1500};
  RcInput rc;
  const auto hear = [&](std::uint8_t component, std::int64_t now_us, bool valid = true) {
    const auto pulses = std::span(kPulses).first(valid ? 8U : 0U);
    return rc.hears(component, now_us) && rc.hear(pulses, kSwitch, State::kHold, now_us, component);
  };
  CHECK(hear(1, 1'000'000));
  CHECK_FALSE(hear(2, 1'400'000));
  CHECK(hear(2, 1'500'000));
  link::SysStatus lost{};
  lost.sensors_present = lost.sensors_enabled = link::mav::kSensorRcReceiver;
  rc.judge(2, lost);
  CHECK_FALSE(hear(2, 1'600'000));
  CHECK_FALSE(hear(1, 1'650'000, false));  // invalid pulses do not make it forget
  CHECK_FALSE(hear(2, 1'700'000));
  CHECK(hear(1, 1'800'000));
  CHECK_FALSE(hear(2, 2'900'000));
  CHECK(hear(1, 3'000'000));
}

TEST_CASE("a receiver stays lost while other components report lost receivers, or a healthy one") {
  link::SysStatus status{};
  status.sensors_present = status.sensors_enabled = link::mav::kSensorRcReceiver;
  RcInput rc;
  for (const unsigned component : {140U, 141U, 142U, 140U}) {
    rc.judge(static_cast<std::uint8_t>(component), status);
  }
  CHECK((rc.is_lost(140) && rc.is_lost(141) && rc.is_lost(142)));
  status.sensors_health = link::mav::kSensorRcReceiver;
  rc.judge(143, status);
  rc.judge(141, status);
  CHECK((rc.is_lost(140) && !rc.is_lost(141) && rc.is_lost(142)));
}

TEST_CASE("while the switch is on it requests MANUAL where the boat can change to it") {
  for (const State state : {State::kHold, State::kFormation, State::kCoast}) {
    Transmitter t;
    t.set(1500, 1500, 1900);
    for (int i = 0; i < 3; ++i) {
      t.hear(state);
      CHECK(t.request() == Request::kManual);
      CHECK(t.rc.sticks());
    }
    t.now_us += 499'999;
    CHECK(t.request() == Request::kManual);
    t.now_us += 1;
    CHECK_FALSE(t.request());
  }
  for (const State state : {State::kDisarmed, State::kManual, State::kTest, State::kFault}) {
    Transmitter t;
    t.set(1500, 1500, 1900);
    t.hear(state);
    CHECK(t.request() == (state == State::kTest ? std::optional(Request::kHold) : std::nullopt));
  }
}

TEST_CASE("in MANUAL, turning the switch off requests HOLD once and releases the sticks") {
  Transmitter t;
  t.set(1500, 1600, 1900);
  t.hear(State::kManual);
  t.set(1500, 1600, 1100);
  t.hear(State::kManual);
  CHECK(t.request() == Request::kHold);
  CHECK_FALSE(t.rc.sticks());
  t.hear(State::kManual);
  CHECK_FALSE(t.request());
}

TEST_CASE("moving a stick takes control from the law, and from nobody else") {
  for (const auto& [steering, throttle] : {std::pair{1500, 1630}, std::pair{1500, 1370},
                                           std::pair{1630, 1500}, std::pair{1370, 1500}}) {
    Transmitter t;
    t.hear(State::kFormation);
    CHECK_FALSE(t.request());
    t.set(static_cast<std::uint16_t>(steering), static_cast<std::uint16_t>(throttle), 1000);
    t.hear(State::kFormation);
    CHECK(t.request() == Request::kManual);
    t.set(1500, 1500, 1000);
    t.hear(State::kManual);
    CHECK(t.rc.sticks());
    CHECK_FALSE(t.request());
    t.hear(State::kFormation);  // an operator asked for it
    CHECK_FALSE(t.rc.sticks());
    CHECK_FALSE(t.request());
  }
  Transmitter stopped;
  stopped.hear(State::kFormation);
  stopped.set(1500, 1900, 1000);
  stopped.hear(State::kFormation);
  stopped.last = State::kHold;  // an operator's HOLD came in the same tick
  CHECK_FALSE(stopped.request());
  Transmitter still;
  still.set(1600, 1400, 1000);
  still.hear(State::kFormation);
  CHECK_FALSE(still.request());
}

TEST_CASE(
    "a throttle at rest at its lower end requests nothing; one that leaves it requests MANUAL") {
  Transmitter t;
  t.set(1500, 1000, 1000);
  for (const State state : {State::kDisarmed, State::kHold, State::kFormation, State::kCoast}) {
    t.hear(state);
    CHECK_FALSE(t.request());
    CHECK_FALSE(t.rc.sticks());
  }
  t.set(1500, 1210, 1000);  // 0.3 beyond the end of its travel at 1100
  t.hear(State::kCoast);
  CHECK_FALSE(t.request());
  t.set(1500, 1230, 1000);
  t.hear(State::kFormation);
  CHECK(t.request() == Request::kManual);
  CHECK(t.rc.sticks());
}

TEST_CASE("the sticks' position when the law starts to drive counts as their rest position") {
  Transmitter t;
  t.set(1500, 1000, 1000);
  t.hear(State::kHold);
  t.set(1500, 1500, 1000);  // centred for MANUAL
  t.hear(State::kManual);
  t.hear(State::kFormation);
  CHECK_FALSE(t.request());
  t.set(1500, 1000, 1000);
  t.hear(State::kFormation);
  CHECK(t.request() == Request::kManual);
}

TEST_CASE("pulses are shares of full thrust ahead and of full moment to starboard") {
  Transmitter t;
  t.set(1700, 1300, 1900);
  t.hear(State::kManual);
  CHECK(t.rc.sticks()->surge == -0.5);
  CHECK(t.rc.sticks()->yaw == 0.5);
  t.set(2100, 1000, 1900);
  t.hear(State::kManual);
  CHECK(t.rc.sticks()->surge == -1);
  CHECK(t.rc.sticks()->yaw == 1);
}

TEST_CASE("a pilot who was silent does not pilot any more, until he takes over again") {
  Transmitter t;
  t.hear(State::kFormation);
  t.set(1900, 1500, 1000);
  t.hear(State::kFormation);
  CHECK(t.request() == Request::kManual);
  CHECK(t.rc.pilots(t.now_us));
  t.now_us += 600'000;
  CHECK_FALSE(t.rc.pilots(t.now_us));
  t.hear(State::kManual);  // an operator's
  CHECK_FALSE(t.rc.sticks());
  CHECK_FALSE(t.rc.pilots(t.now_us));
}

TEST_CASE("a throttle under 975 us is that of a receiver without its transmitter, not a pilot's") {
  for (const std::uint16_t throttle : std::initializer_list<std::uint16_t>{800, 900, 950, 974}) {
    for (const State state : {State::kHold, State::kFormation, State::kManual}) {
      Transmitter t;
      t.hear(state);
      t.set(1500, throttle, 1900);
      CHECK_FALSE(t.hear(state));
      CHECK_FALSE(t.request());
      CHECK_FALSE(t.rc.sticks());
    }
  }
  Transmitter t;
  t.set(1500, 975, 1900);
  CHECK(t.hear(State::kHold));
}

TEST_CASE("another receiver may take the place of one that has sent no valid pulses for 0.5 s") {
  Transmitter t;
  t.set(1500, 1500, 1900);
  CHECK(t.rc.hear(t.pulses, kSwitch, State::kManual, t.now_us, 140));
  t.set(1500, 900, 1900);
  for (int k = 0; k < 5; ++k) {
    CHECK_FALSE(t.rc.hears(151, t.now_us));
    t.now_us += 100'000;
    CHECK_FALSE(t.rc.hear(t.pulses, kSwitch, State::kManual, t.now_us, 140));
  }
  CHECK(t.rc.hears(140, t.now_us));
  CHECK(t.rc.hears(151, t.now_us));
}

TEST_CASE("invalid pulses, or a missing channel, are ignored") {
  for (const std::uint16_t wrong : std::initializer_list<std::uint16_t>{0, 799, 2201, 65535}) {
    for (const std::size_t channel : {0U, 2U, 6U}) {
      Transmitter t;
      t.set(1500, 1500, 1900);
      t.pulses[channel] = wrong;
      CHECK_FALSE(t.hear(State::kHold));
      CHECK_FALSE(t.rc.sticks());
    }
  }
  Transmitter t;
  t.set(1500, 1500, 1900);
  CHECK_FALSE(t.rc.hear(std::span(t.pulses).first(6), kSwitch, State::kHold, 0));
  CHECK_FALSE(t.rc.hear(std::span(t.pulses).first(2), 1, State::kHold, 0));
  CHECK_FALSE(t.rc.hear({}, kSwitch, State::kHold, 0));
}

}  // namespace
}  // namespace flotilla::app
