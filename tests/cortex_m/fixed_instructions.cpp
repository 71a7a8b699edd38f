// SPDX-License-Identifier: MIT
// Mean instructions per call of Q16's functions and of newlib's float functions, without those of
// the call itself. Prints a line each: q16.sin 46, float.sin 75, …
#include <array>
#include <charconv>
#include <cstdint>
#include <string_view>

#include "core/fixed_rivals.hpp"
#include "cortex_m/platform.hpp"

namespace flotilla::target {
namespace {

constexpr std::size_t kArguments = 256;
constexpr int kRepeats = 10;

template <class T>
using Function = T (*)(T, T);
template <class T>
using Arguments = std::array<T, kArguments>;

volatile std::uint8_t seen;

template <class T>
[[gnu::noipa]] std::uint32_t spent(Function<T> function, const Arguments<T>& x,
                                   const Arguments<T>& y) {
  instructions();
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    for (std::size_t i = 0; i < kArguments; ++i) {
      const T result = function(x[i], y[i]);
      seen = reinterpret_cast<const std::uint8_t&>(result);
    }
  }
  return instructions();
}

template <class T>
void tell(const char* of, const char* name, Function<T> function, const Arguments<T>& x,
          const Arguments<T>& y) {
  constexpr std::uint32_t kCalls = kArguments * kRepeats;
  const std::uint32_t empty = spent<T>([](T first, T) { return first; }, x, y);
  const std::uint32_t mean = (spent<T>(function, x, y) - empty + kCalls / 2) / kCalls;
  std::array<char, 12> digits{};
  std::to_chars(digits.data(), digits.data() + digits.size() - 1, mean);
  for (const char* text : {of, name, " ", static_cast<const char*>(digits.data()), "\n"}) {
    print(text);
  }
}

}  // namespace

bool run() {
  for (const testing::Rival& rival : testing::kRivals) {
    const testing::Timed<kArguments> timed(rival);
    tell<core::Q16>("q16.", rival.name, rival.ours, timed.x, timed.y);
    tell<float>("float.", rival.name, rival.floating, timed.float_x, timed.float_y);
  }
  return true;
}

}  // namespace flotilla::target
