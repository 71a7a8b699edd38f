// SPDX-License-Identifier: MIT
#include "link/mavlink/signing.hpp"

#include <cstdint>
#include <cstring>
// mavlink_sha256.h relies on the two headers above.
#define MAVLINK_HELPER static inline
#include <mavlink_sha256.h>

#include <algorithm>

namespace flotilla::link {
namespace {

constexpr std::int64_t kEpoch_us = 1'420'070'400'000'000;  // 2015-01-01, since 1970
constexpr std::uint64_t kLatest = (std::uint64_t{1} << 48U) - 1;
constexpr std::uint64_t kSecond = 100'000, kMinute = 60 * kSecond, kDay = 1440 * kMinute;
// pymavlink starts its timestamps at its clock, adds one for each message, and follows newer ones
// that it receives, so a sender that receives nothing falls behind its clock. Such late timestamps
// pass if at most this many of its messages are lost in a row. A replayed recording of a sender
// that stamps by its clock has greater steps, and does not pass.
constexpr std::uint64_t kDragged = 500;
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

/// Compares in constant time.
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
  timestamp_ = stored_ = std::min(stored, kLatest);
  set_clock(clock);
}

void Signing::set_clock(std::uint64_t now, bool known) {
  known_ = known;
  clock_ = std::min(now, kLatest);
  timestamp_ = std::max(timestamp_, clock_);
}

std::uint32_t Signing::clock_s() const { return static_cast<std::uint32_t>(clock_ / kSecond); }

/// Whether a sender's first message after our restart may be a replay from before it. A stored time
/// a day or more ahead of a known clock came from a wrong clock and does not count.
bool Signing::may_be_old(std::uint64_t timestamp) const {
  return timestamp <= stored_ && (!known_ || stored_ < clock_ + kDay);
}

/// Whether the sender's timestamps count its messages, and it was heard within the last minute.
bool Signing::drags(const Stream& stream, std::uint64_t timestamp) const {
  return stream.heard_s != 0 && clock_s() - stream.heard_s < kMinute / kSecond &&
         timestamp - stream.timestamp <= kDragged;
}

Signing::Stream* Signing::find(Address from, std::uint8_t link_id) {
  const std::span<Stream> used = room_.first(used_);
  const auto it = std::ranges::find_if(
      used, [&](const Stream& s) { return s.from == from && s.link_id == link_id; });
  return it == used.end() ? nullptr : &*it;
}

Signing::Stream* Signing::find_or_add(Address from, std::uint8_t link_id) {
  Stream* const stream = find(from, link_id);
  if (stream != nullptr || used_ == room_.size()) return stream;
  room_[used_] = {from, link_id, 0, 0, 0};
  return &room_[used_++];
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
  if (known_ && timestamp > clock_ + kMinute) return kFuture;
  Stream* stream = find(from, link_id);
  if (stream != nullptr && timestamp <= stream->timestamp) return kReplayed;
  // An exempt message alone leaves its stream's timestamp at 0.
  const bool is_first = stream == nullptr || stream->timestamp == 0;
  if (is_first && may_be_old(timestamp)) return kStale;
  const bool is_late = known_ && timestamp + kMinute < clock_;
  if (is_late && (is_first || !drags(*stream, timestamp))) return kStale;
  stream = find_or_add(from, link_id);
  if (stream == nullptr) return kNoRoom;
  stream->timestamp = timestamp;
  stream->heard_s = clock_s();
  if (!known_) timestamp_ = std::max(timestamp_, timestamp);
  return kGood;
}

bool Signing::take_exemption(std::span<const std::uint8_t> frame, const Message& message) {
  if (exemption_ == nullptr || !exemption_(message)) return false;
  const auto block = frame.last(kSignatureBlockBytes);
  const std::uint64_t timestamp = read_timestamp(block.subspan(1));
  Stream* const stream = find_or_add({frame[5], frame[6]}, block[0]);
  if (stream == nullptr || timestamp <= std::max(stream->timestamp, stream->exempt_before)) {
    return false;
  }
  stream->exempt_before = timestamp;
  return true;
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
