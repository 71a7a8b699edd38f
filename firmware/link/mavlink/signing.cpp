// SPDX-License-Identifier: MIT
#include "link/mavlink/signing.hpp"

#include <cstdint>
#include <cstring>
// After them: it relies on both.
#define MAVLINK_HELPER static inline
#include <mavlink_sha256.h>

#include <algorithm>

namespace flotilla::link {
namespace {

constexpr std::int64_t kEpoch_us = 1'420'070'400'000'000;  // 2015-01-01, since 1970
constexpr std::uint64_t kLatest = (std::uint64_t{1} << 48U) - 1;
constexpr std::uint64_t kMinute = 6'000'000, kDay = 24 * 60 * kMinute;
constexpr std::size_t kTimestampBytes = 6, kDigestBytes = 6;

std::uint64_t read_timestamp(std::span<const std::uint8_t> bytes) {
  std::uint64_t timestamp = 0;
  for (std::size_t i = 0; i < kTimestampBytes; ++i) timestamp |= std::uint64_t{bytes[i]} << 8 * i;
  return timestamp;
}

std::array<std::uint8_t, kDigestBytes> digest(const SigningKey& key,
                                              std::span<const std::uint8_t> frame,
                                              std::span<const std::uint8_t> link_and_time) {
  const auto add = [](mavlink_sha256_ctx& context, std::span<const std::uint8_t> bytes) {
    mavlink_sha256_update(&context, bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  };
  mavlink_sha256_ctx context;
  mavlink_sha256_init(&context);
  add(context, key);
  add(context, frame);
  add(context, link_and_time);
  std::array<std::uint8_t, kDigestBytes> result;
  mavlink_sha256_final_48(&context, result.data());
  return result;
}

/// Takes constant time, wherever the first difference is.
bool equal(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) {
  unsigned difference = 0;
  for (std::size_t i = 0; i < kDigestBytes; ++i) difference |= unsigned{a[i]} ^ unsigned { b[i] };
  return difference == 0;
}

}  // namespace

std::uint64_t signing_time(std::int64_t unix_us) {
  if (unix_us <= kEpoch_us) return 0;
  return std::min(static_cast<std::uint64_t>(unix_us - kEpoch_us) / 10, kLatest);
}

void Signing::start(const SigningKey& key, std::uint64_t clock, std::uint64_t stored) {
  key_ = key;
  has_key_ = true;
  used_ = 0;
  timestamp_ = std::min(stored, kLatest);
  set_clock(clock);
  // A clock that starts a little behind, as without a battery, must not make old messages valid.
  floor_ = stored > clock_ && stored - clock_ < kDay ? stored : 0;
}

void Signing::set_clock(std::uint64_t now) {
  clock_ = std::min(now, kLatest);
  timestamp_ = std::max(timestamp_, clock_);
}

Signing::Stream* Signing::find(Address from, std::uint8_t link_id) {
  const std::span<Stream> used = room_.first(used_);
  const auto it = std::ranges::find_if(
      used, [&](const Stream& s) { return s.from == from && s.link_id == link_id; });
  return it == used.end() ? nullptr : &*it;
}

SignatureVerdict Signing::check(std::span<const std::uint8_t> frame) {
  using enum SignatureVerdict;
  if (!has_key_ || frame.size() < kHeaderBytes2 + kChecksumBytes + kSignatureBlockBytes)
    return kForged;
  const auto block = frame.last(kSignatureBlockBytes);
  const auto expected = digest(key_, frame.first(frame.size() - kSignatureBlockBytes),
                               block.first(1 + kTimestampBytes));
  if (!equal(expected, block.last(kDigestBytes))) return kForged;

  const Address from{frame[5], frame[6]};
  const std::uint8_t link_id = block[0];
  const std::uint64_t timestamp = read_timestamp(block.subspan(1));
  if (timestamp > clock_ + kMinute) return kFuture;
  Stream* stream = find(from, link_id);
  if (stream != nullptr) {
    if (timestamp <= stream->timestamp) return kReplayed;
  } else {
    if (timestamp + kMinute < std::max(clock_, floor_)) return kStale;
    if (used_ == room_.size()) return kNoRoom;
    stream = &room_[used_++];
  }
  *stream = {from, link_id, timestamp};
  return kGood;
}

void Signing::sign(std::span<const std::uint8_t> frame, std::uint8_t link_id,
                   std::span<std::uint8_t, kSignatureBlockBytes> block) {
  timestamp_ = std::min(timestamp_ + 1, kLatest);
  block[0] = link_id;
  for (std::size_t i = 0; i < kTimestampBytes; ++i) {
    block[1 + i] = static_cast<std::uint8_t>(timestamp_ >> 8 * i);
  }
  const auto signature = digest(key_, frame, block.first<1 + kTimestampBytes>());
  std::copy(signature.begin(), signature.end(), block.last<kDigestBytes>().begin());
}

}  // namespace flotilla::link
