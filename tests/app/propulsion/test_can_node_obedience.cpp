// SPDX-License-Identifier: MIT
// ESCs that drive while commanded to stop.
#include <doctest/doctest.h>

#include <limits>

#include "app/propulsion/can_node.hpp"

namespace flotilla::app {
namespace {

constexpr std::int64_t kTick_us = 10'000, kStatus_us = 50'000;

struct Bus {
  CanNode node{{20, 1}, 0};
  link::Counters counters;
  CanOutput out;
  std::int64_t now_us = 1'000'000;
  std::int16_t port_command = 0;
  bool armed = false;
  std::uint8_t power_pct = 0, transfer_id = 0;
  std::int32_t rpm = 0;
  float current_A = 0;

  void status(std::uint8_t index, std::uint8_t power, std::int32_t turns, float current = 0) {
    link::EscStatus message;
    message.esc_index = index;
    message.current = current;
    message.power_rating_pct = power;
    message.rpm = turns;
    link::Payload payload;
    const std::size_t size = write_payload(message, payload);
    std::array<link::CanFrame, 5> frames;
    const link::Route route{16, link::TransferKind::kMessage, link::EscStatus::kType.id,
                            static_cast<std::uint8_t>(30 + index), 0};
    const std::size_t n = link::split_transfer(route, link::EscStatus::kType, transfer_id,
                                               std::span(payload).first(size), frames);
    for (std::size_t i = 0; i < n; ++i) {
      node.on_frame(frames[i].id, frames[i].bytes(), now_us, counters);
    }
  }

  /// The port ESC, index 0, reports its state; the other one is at rest. Seconds until the ESCs
  /// count as disobedient, or −1.
  double run(double seconds) {
    const std::int64_t begin_us = now_us;
    while (now_us < begin_us + static_cast<std::int64_t>(seconds * 1e6)) {
      now_us += kTick_us;
      if (now_us % kStatus_us == 0) {
        status(0, power_pct, rpm, current_A);
        status(1, 0, 0);
        transfer_id = (transfer_id + 1U) & 0x1FU;
      }
      out.count = 0;
      link::RawCommand command{2, {port_command, 0}};
      node.send(command, armed, now_us, counters, out);
      if (!obey()) return static_cast<double>(now_us - begin_us) * 1e-6;
    }
    return -1;
  }
  bool obey() const { return node.escs_obey(0, 1, now_us); }
};

TEST_CASE(
    "a propeller is at rest if its ESC reports almost no turns, and has reported turns before") {
  Bus bus;
  bus.run(1);
  CHECK_FALSE(bus.node.rests(0));
  bus.rpm = -864;
  bus.run(1);
  CHECK_FALSE(bus.node.rests(0));
  bus.rpm = 290;
  bus.run(1);
  CHECK(bus.node.rests(0));
  CHECK_FALSE(bus.node.rests(1));
}

TEST_CASE("an ESC that drives while disarmed is detected within a second") {
  Bus bus;
  CHECK(bus.run(3) == -1);
  bus.power_pct = 50;
  const double after_s = bus.run(3);
  CHECK(after_s >= 0.45);
  CHECK(after_s <= 1.0);
  // A disarmed ESC is commanded to stop, whatever the raw command is.
  Bus told;
  told.port_command = 4000;
  told.power_pct = 50;
  CHECK(told.run(3) > 0);
}

TEST_CASE("an ESC commanded to turn may turn, and has a second to stop when commanded") {
  Bus bus;
  bus.armed = true;
  bus.port_command = 4000;
  bus.power_pct = 50;
  bus.rpm = 2000;
  CHECK(bus.run(20) == -1);
  bus.port_command = 0;
  const double after_s = bus.run(3);
  CHECK(after_s >= 0.95);
  CHECK(after_s <= 1.2);
}

TEST_CASE("a propeller turned by water runs down; one still turning after 5 s is driven") {
  for (const std::int32_t rpm : {2000, -2000}) {  // the sign is unreliable
    Bus bus;
    bus.armed = true;
    bus.port_command = 4000;
    bus.rpm = rpm;
    CHECK(bus.run(10) == -1);
    bus.port_command = 0;
    CHECK(bus.run(4.5) == -1);
    const double more_s = bus.run(1);
    CHECK(more_s > 0);
    bus.rpm = 250;
    for (int k = 0; k < 110; ++k) bus.run(0.01);
    CHECK(bus.run(10) == -1);
  }
}

TEST_CASE("water may turn a propeller for any time if its ESC measures no current") {
  Bus bus;
  bus.armed = true;
  bus.port_command = 4000;
  bus.rpm = 2000;
  bus.current_A = 20;
  CHECK(bus.run(10) == -1);
  bus.port_command = 0;
  bus.current_A = 0.1F;
  CHECK(bus.run(60) == -1);
  bus.current_A = -3;  // it brakes
  CHECK(bus.run(60) == -1);
  for (const float current : {0.6F, std::numeric_limits<float>::quiet_NaN()}) {
    bus.current_A = current;
    const double after_s = bus.run(6);
    CHECK(after_s >= 4.9);
    CHECK(after_s <= 5.1);
    bus.current_A = 0;
    for (int k = 0; k < 110; ++k) bus.run(0.01);
  }
}

TEST_CASE("an ESC that has never measured a current does not prove that it draws none") {
  Bus bus;
  bus.rpm = 2000;
  CHECK(bus.run(6) > 0);
}

TEST_CASE("an ESC obeys again a second after it stands still") {
  Bus bus;
  bus.power_pct = 80;
  CHECK(bus.run(3) > 0);
  bus.power_pct = 0;
  int ticks = 0;
  for (; !bus.obey(); ++ticks) bus.run(0.01);
  CHECK(ticks >= 90);
  CHECK(ticks <= 110);
}

TEST_CASE("one report of power, or two a second apart, is no disobedience") {
  Bus bus;
  for (int k = 0; k < 20; ++k) {
    bus.power_pct = 50;
    CHECK(bus.run(0.3) == -1);
    bus.power_pct = 4;
    CHECK(bus.run(0.1) == -1);
  }
}

TEST_CASE("an ESC that drives none of our propellers is ignored") {
  Bus bus;
  bus.run(1);
  for (int k = 0; k < 100; ++k) {
    bus.status(5, 100, 9000);
    CHECK(bus.run(0.05) == -1);
  }
}

}  // namespace
}  // namespace flotilla::app
