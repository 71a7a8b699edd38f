// SPDX-License-Identifier: MIT
// Frames on a boat's CAN bus, with ticks in between. An op is a byte: 0x03 what, 0x1C how much time
// a tick takes (kSteps_us); then what any_frame() or any_transfer() reads.
#include "fuzz/can_ops.hpp"
#include "fuzz/setups.hpp"

namespace flotilla::fuzz {
namespace {

template <class S>
class Play {
 public:
  explicit Play(const Setup& setup)
      : boat_(setup), node_(static_cast<std::uint8_t>(setup.parameters.CAN_NODE)) {}

  void run(Stream& in) {
    while (!in.empty()) op(in);
    boat_.tick(now_us_ += kSteps_us[0]);
  }

 private:
  void op(Stream& in) {
    const unsigned op = in.byte();
    const auto push = [&](const link::CanFrame& frame) { boat_.on_can(frame, now_us_); };
    switch (op & 3U) {
      case 0:
        return push(any_frame(in));
      case 1:
      case 2:
        return any_transfer(in, node_, push);
      default:
        boat_.tick(now_us_ += kSteps_us[op >> 2U & 7U]);
    }
  }

  WatchedBoat<S> boat_;
  std::uint8_t node_;
  std::int64_t now_us_ = 1'000'000;
};

}  // namespace
}  // namespace flotilla::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return flotilla::fuzz::play<flotilla::fuzz::Play>(data, size);
}
