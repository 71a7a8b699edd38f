// SPDX-License-Identifier: MIT
// write_logs DIR: writes a boat's output of ten seconds to logs in DIR, for test_logs.py.
#include <array>
#include <cstdio>

#include "link/mavlink/encode.hpp"
#include "linux/logs/logs.hpp"

int main(int count, char** arguments) {
  using namespace flotilla;
  if (count != 2) return 2;
  target::Logs logs(
      {.directory = arguments[1], .can_name = "vcan0", .file_bytes = 5000, .links = 2});
  link::MavlinkEncoder boat({2, 1}), leader({1, 1});
  std::array<std::uint8_t, 512> bytes;
  for (std::uint32_t tick = 0; tick < 100; ++tick) {
    const std::int64_t unix_us = 1700000000123456 + std::int64_t{tick} * 100000;
    link::Attitude attitude{};
    attitude.time_boot_ms = tick * 100;
    attitude.yaw = 0.01F * static_cast<float>(tick);
    std::size_t size = boat.encode(link::Heartbeat{tick, 11, 0, 0x81, 4}, bytes);
    size += boat.encode(attitude, std::span(bytes).subspan(size));
    logs.mavlink(0, target::Direction::kSent, std::span(bytes).first(size), unix_us);

    size = leader.encode(link::LocalPositionNed{tick * 100, 1.5F, 2.5F, 0, 0, 0, 0}, bytes);
    // as a serial port delivers it
    logs.mavlink(1, target::Direction::kReceived, std::span(bytes).first(7), unix_us + 10);
    logs.mavlink(1, target::Direction::kReceived, std::span(bytes).first(size).subspan(7),
                 unix_us + 20);

    link::CanFrame frame{0x0704060A, 5, {0xFF, 0x7C, 0x02, 0x00, 0}};
    frame.data[4] = static_cast<std::uint8_t>(0xC0U | (tick & 31U));
    logs.can(frame, unix_us + 30);
  }
  return 0;
}
