// SPDX-License-Identifier: MIT
// Bytes on a boat's MAVLink links, in chunks, with ticks in between. A chunk is
//   flags · length · bytes
// flags: 0x03 link, 0x04 its datagram ends, 0x08 a tick follows, 0x70 after so much time (kSteps_us),
// 0x80 the frame that the bytes begin with gets its right checksum and signature.
#include "fuzz/mavlink_ops.hpp"
#include "fuzz/setups.hpp"

namespace flotilla::fuzz {
namespace {

template <class S>
class Play {
 public:
  explicit Play(const Setup& setup) : boat_(setup), talkers_(boat_, setup.parameters) {}

  void run(Stream& in) {
    while (!in.empty()) chunk(in);
    boat_.tick(now_us_ += kSteps_us[0]);
  }

 private:
  void chunk(Stream& in) {
    const unsigned flags = in.byte();
    const std::size_t link = (flags & 3U) % boat_.links();
    const std::size_t length = in.byte();
    talkers_.bytes(in.take(length), (flags & 0x80U) != 0, now_us_, link);
    if ((flags & 4U) != 0) boat_.end_of_datagram(now_us_, link);
    if ((flags & 8U) != 0) boat_.tick(now_us_ += kSteps_us[flags >> 4U & 7U]);
  }

  WatchedBoat<S> boat_;
  Talkers<S> talkers_;
  std::int64_t now_us_ = 1'000'000;
};

}  // namespace
}  // namespace flotilla::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return flotilla::fuzz::play<flotilla::fuzz::Play>(data, size);
}
