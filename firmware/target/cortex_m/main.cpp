// SPDX-License-Identifier: MIT
// Plays the stream of standard input to a boat; prints the digest of what it says and what that took.
#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstddef>
#include <cstring>
#include <new>
#include <span>
#include <string_view>

#include "target/cortex_m/platform.hpp"
#include "target/cortex_m/player.hpp"

namespace flotilla::target {
namespace {

/// Instructions between one tick's end and the next one's, without what the player itself does.
struct Cost {
  std::uint32_t ticks = 0, least = UINT32_MAX, most = 0;
  std::uint64_t all = 0;

  void add(std::uint32_t instructions) {
    ++ticks;
    least = std::min(least, instructions);
    most = std::max(most, instructions);
    all += instructions;
  }
};

void tell(std::string_view name, std::uint64_t number) {
  std::array<char, 64> line{};
  char* end = std::ranges::copy(name, line.data()).out;
  *end++ = ' ';
  end = std::to_chars(end, line.data() + line.size() - 2, number).ptr;
  *end = '\n';
  print(line.data());
}

void print_digest(const std::array<std::uint8_t, 32>& digest) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  print("digest ");
  for (const std::uint8_t byte : digest) {
    const std::array<char, 3> text{kDigits[byte >> 4U], kDigits[byte & 15U], '\0'};
    print(text.data());
  }
  print("\n");
}

bool play_all(Player& player, Cost& every, Cost& driving) {
  static std::array<std::uint8_t, kMostBytes> bytes;
  std::array<std::uint8_t, 12> head;
  static_assert(std::endian::native == std::endian::little);
  std::uint32_t cost = 0;
  while (read(head)) {
    Record record;
    std::memcpy(&record.t_us, head.data(), 8);
    std::memcpy(&record.port, head.data() + 8, 2);
    std::memcpy(&record.length, head.data() + 10, 2);
    if (record.length > bytes.size()) return false;
    const auto data = std::span(bytes).first(record.length);
    if (!read(data)) return false;
    instructions();
    if (!player.play(record, data)) return false;
    cost += instructions();
    if (!player.ticked()) continue;
    every.add(cost);
    if (player.drives()) driving.add(cost);
    cost = 0;
    player.digest();
  }
  return true;
}

}  // namespace

bool run() {
  // Never destroyed: there is nothing after it.
  alignas(Player) static std::array<std::byte, sizeof(Player)> place;
  auto& player = *new (place.data()) Player;
  Cost every, driving;
  const bool well = play_all(player, every, driving);
  if (!well) print("the stream is damaged\n");
  print_digest(player.finish());
  tell("ticks", every.ticks);
  tell("ticks_driving", driving.ticks);
  tell("instructions_mean", every.all / std::max<std::uint32_t>(every.ticks, 1));
  tell("instructions_driving", driving.all / std::max<std::uint32_t>(driving.ticks, 1));
  tell("instructions_driving_least", driving.least);
  tell("instructions_most", every.most);
  tell("stack_bytes", most_stack_bytes());
  tell("boat_bytes", sizeof(app::Boat<Scalar>));
  return well;
}

}  // namespace flotilla::target
