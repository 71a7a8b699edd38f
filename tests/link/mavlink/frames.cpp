// SPDX-License-Identifier: MIT
// For test_mavlink_oracle.py, a line a message:
//   mavlink_frames SEED             type, frame and fields of one random message of every type
//   mavlink_frames < hex frames     sender, target, sequence, type and fields of each
// A type is its place in link::Message; floats are hexadecimal, texts their bytes after an x.
#include <cstdio>
#include <iostream>
#include <string>

#include "link/any_message.hpp"
#include "link/fields.hpp"

namespace flotilla::testing {
namespace {

struct Print {
  void operator()(float x) const { std::printf(" %a", static_cast<double>(x)); }
  void operator()(std::uint64_t x) const {
    std::printf(" %llu", static_cast<unsigned long long>(x));
  }
  template <std::integral Number>
  void operator()(Number x) const {
    std::printf(" %lld", static_cast<long long>(x));
  }
  template <class Number, std::size_t N>
  void operator()(const std::array<Number, N>& numbers) const {
    for (const Number x : numbers) (*this)(x);
  }
  template <std::size_t N>
  void operator()(const link::Text<N>& text) const {
    std::printf(" x");
    for (const char c : text) std::printf("%02x", static_cast<unsigned char>(c));
  }
};

void print_fields(const link::Message& message) {
  std::visit([](const auto& m) { each_field(m, Print{}); }, message);
  std::printf("\n");
}

void encode(std::uint32_t seed) {
  AnyMessage any(seed);
  link::MavlinkEncoder encoder({7, 191});
  for (std::size_t index = 1; index < kMessages; ++index) {
    const link::Message message = any(index);
    std::printf("%zu ", index);
    for (const std::uint8_t byte : frame_of(encoder, message)) std::printf("%02x", byte);
    print_fields(message);
  }
}

void decode(std::istream& in) {
  link::MavlinkDecoder decoder;
  link::Counters counters;
  for (std::string hex; std::getline(in, hex);) {
    Bytes frame;
    for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
      frame.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(i, 2), nullptr, 16)));
    }
    for (const link::Received& r : received_from(decoder, frame, counters)) {
      std::printf("%d %d %d %d %d %zu", r.from.system, r.from.component, r.target.system,
                  r.target.component, r.sequence, r.message.index());
      print_fields(r.message);
    }
  }
}

}  // namespace
}  // namespace flotilla::testing

int main(int argc, char** argv) {
  if (argc > 1) {
    flotilla::testing::encode(static_cast<std::uint32_t>(std::stoul(argv[1])));
  } else {
    flotilla::testing::decode(std::cin);
  }
}
