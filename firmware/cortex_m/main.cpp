// SPDX-License-Identifier: MIT
// Replays a stream from standard input to a boat; prints the digest of its output and the cost.
#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstddef>
#include <cstring>
#include <new>
#include <span>

#include "cortex_m/platform.hpp"
#include "cortex_m/player.hpp"

namespace flotilla::target {
namespace {

struct Ticks {
  std::uint32_t all = 0, driving = 0;
  std::uint32_t most = 0;  ///< instructions
};

void print_number(std::uint32_t number) {
  std::array<char, 16> text{' '};
  std::to_chars(text.data() + 1, text.data() + text.size() - 1, number);
  print(text.data());
}

void tell(const char* name, std::uint32_t number) {
  print(name);
  print_number(number);
  print("\n");
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

/// Prints the instructions of each tick that drives, since the last tick and without the player's.
bool play_all(Player& player, Ticks& ticks) {
  static std::array<std::uint8_t, kMaxBytes> bytes;
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
    ++ticks.all;
    ticks.most = std::max(ticks.most, cost);
    if (player.drives()) {
      ++ticks.driving;
      print_number(cost);
    }
    cost = 0;
    player.digest();
  }
  return true;
}

}  // namespace

bool run() {
  // Never destroyed: the program ends after it.
  alignas(Player) static std::array<std::byte, sizeof(Player)> place;
  auto& player = *new (place.data()) Player;
  Ticks ticks;
  print("instructions_driving");
  const bool well = play_all(player, ticks);
  print("\n");
  if (!well) print("the stream is damaged\n");
  print_digest(player.finish());
  tell("ticks", ticks.all);
  tell("ticks_driving", ticks.driving);
  tell("instructions_most", ticks.most);
  tell("stack_bytes", static_cast<std::uint32_t>(most_stack_bytes()));
  tell("boat_bytes", static_cast<std::uint32_t>(sizeof(app::Boat<Scalar>)));
  return well;
}

}  // namespace flotilla::target
