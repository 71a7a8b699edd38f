// SPDX-License-Identifier: MIT
// The boat's MAVLink links: a decoder, an encoder and this tick's outgoing bytes for each.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "link/mavlink_decode.hpp"
#include "link/mavlink_encode.hpp"
#include "link/signing.hpp"

namespace flotilla::app {

constexpr std::size_t kMaxLinks = 4;

/// What a link's signatures are worth.
enum class SigningPolicy : std::uint8_t {
  kOff,       ///< sends unsigned, looks at no signature
  kAccept,    ///< sends signed; takes unsigned messages too, but none that is signed wrongly
  kRequired,  ///< sends signed; takes nothing unsigned but a radio's RADIO_STATUS
};

/// By its name in a configuration.
constexpr std::optional<SigningPolicy> signing_policy(std::string_view name) {
  if (name == "off") return SigningPolicy::kOff;
  if (name == "accept") return SigningPolicy::kAccept;
  if (name == "required") return SigningPolicy::kRequired;
  return std::nullopt;
}

class MavlinkLinks {
 public:
  /// count: 1 … kMaxLinks
  MavlinkLinks(std::size_t count, link::Address self) : count_(count) {
    for (Link& link : links_) link.encoder = link::MavlinkEncoder(self);
  }

  std::size_t count() const { return count_; }

  link::MavlinkDecoder& decoder(std::size_t link) { return links_[link].decoder; }

  link::Signing& signing() { return signing_; }
  const link::Signing& signing() const { return signing_; }

  /// Without a key in signing() no message counts as signed.
  void set_policy(std::size_t link, SigningPolicy policy) { links_[link].policy = policy; }

  /// The next message that this link's policy lets through.
  std::optional<link::Received> next(std::size_t link, link::Counters& counters) {
    Link& l = links_[link];
    while (auto received = l.decoder.next(counters, signing_of(l))) {
      const bool radio = std::holds_alternative<link::RadioStatus>(received->message);
      if (l.policy != SigningPolicy::kRequired || received->is_signed || radio) return received;
      ++counters.mavlink_unsigned_refused;
    }
    return std::nullopt;
  }

  /// Telemetry on this link keeps to so many bytes a second; 0: no limit.
  void limit(std::size_t link, std::uint32_t bytes_per_s) { links_[link].rate_Bps = bytes_per_s; }

  std::uint32_t limit(std::size_t link) const { return links_[link].rate_Bps; }

  /// Whether a limited link has earned what may be sent now; what is sent then is earned later.
  bool has_credit(std::size_t link) const {
    return links_[link].rate_Bps == 0 || links_[link].credit > 0;
  }

  /// The same for what can wait: two fifths of the rate are kept for it, and what the state leaves.
  bool has_spare_credit(std::size_t link) const {
    const Link& l = links_[link];
    return l.rate_Bps == 0 || l.reserve > 0 || l.credit > most(l) / 2;
  }

  /// send() of what can wait.
  void send_spare(std::size_t link, const link::Message& message, link::Counters& counters) {
    Link& l = links_[link];
    const std::size_t before = l.size;
    send(link, message, counters);
    const auto sent = static_cast<std::int64_t>(l.size - before) * kSecond_us;
    l.reserve = std::max(l.reserve - sent, -most(l));
  }

  /// Bytes that still fit into this tick's output.
  std::size_t room(std::size_t link) const { return links_[link].bytes.size() - links_[link].size; }

  /// A message that finds no room waits for nobody: it is dropped whole and counted.
  void send(std::size_t link, const link::Message& message, link::Counters& counters) {
    Link& l = links_[link];
    const std::size_t size = l.encoder.encode(message, std::span(l.bytes).subspan(l.size),
                                              signing_of(l), static_cast<std::uint8_t>(link));
    l.size += size;
    spend(l, size);
    if (size == 0) ++counters.mavlink_not_sent;
  }

  void broadcast(const link::Message& message, link::Counters& counters) {
    for (std::size_t link = 0; link < count_; ++link) send(link, message, counters);
  }

  /// Another's frame, unchanged, with the next tick.
  void forward(std::size_t link, std::span<const std::uint8_t> frame, link::Counters& counters) {
    Link& l = links_[link];
    if (frame.size() > l.forwarded.size() - l.forwarded_size) {
      ++counters.mavlink_not_sent;
      return;
    }
    std::copy(frame.begin(), frame.end(), l.forwarded.data() + l.forwarded_size);
    l.forwarded_size += frame.size();
  }

  /// Whether a heartbeat under our own ids is one that we sent ourselves, heard again (a broadcast
  /// comes back to the link that listens for broadcasts).
  bool is_echo(const link::Received& heartbeat) const {
    for (const Link& link : links_) {
      for (const auto sequence : link.beats) {
        if (sequence == heartbeat.sequence) return true;
      }
    }
    return false;
  }

  /// A heartbeat of ours to every link.
  void beat(const link::Heartbeat& heartbeat, link::Counters& counters) {
    for (std::size_t i = 0; i < count_; ++i) {
      send(i, heartbeat, counters);
      links_[i].beats = {links_[i].beats[1], links_[i].encoder.last_sequence()};
    }
  }

  /// Under another system id from now on.
  void rename(link::Address self) {
    for (Link& link : links_) link.encoder.rename(self);
  }

  std::span<const std::uint8_t> bytes(std::size_t link) const {
    return {links_[link].bytes.data(), links_[link].size};
  }

  /// Begins a tick, dt_us after the one before.
  void begin(std::int64_t dt_us) {
    for (Link& link : links_) {
      std::copy_n(link.forwarded.begin(), link.forwarded_size, link.bytes.begin());
      link.size = std::exchange(link.forwarded_size, 0);
      spend(link, link.size);
      const std::int64_t earned = std::int64_t{link.rate_Bps} * std::min(dt_us, kSecond_us);
      link.credit = std::min(link.credit + earned, most(link));
      link.reserve = std::min(link.reserve + earned * 2 / 5, most(link) * 2 / 5);
    }
  }

 private:
  struct Link {
    link::MavlinkDecoder decoder;
    link::MavlinkEncoder encoder;
    std::array<std::uint8_t, 1400> bytes{};  // a datagram that no network cuts up
    std::size_t size = 0;
    std::array<std::uint8_t, 700> forwarded{};
    std::size_t forwarded_size = 0;
    std::array<std::optional<std::uint8_t>, 2> beats{};  // sequence numbers of the last heartbeats
    SigningPolicy policy = SigningPolicy::kOff;
    std::uint32_t rate_Bps = 0;
    std::int64_t credit = 0;   // bytes × 10⁶
    std::int64_t reserve = 0;  // the same, of what is kept for what can wait
  };
  static constexpr std::int64_t kSecond_us = 1'000'000;

  /// Half a second's worth may be saved up.
  static std::int64_t most(const Link& link) {
    return std::int64_t{link.rate_Bps} * kSecond_us / 2;
  }

  /// What others' traffic or answers overdraw is forgotten soon: the state must go on.
  static void spend(Link& link, std::size_t bytes) {
    link.credit -= static_cast<std::int64_t>(bytes) * kSecond_us;
    link.credit = std::max(link.credit, -most(link));
  }

  link::Signing* signing_of(const Link& link) {
    return link.policy == SigningPolicy::kOff || !signing_.has_key() ? nullptr : &signing_;
  }

  std::size_t count_;
  std::array<Link, kMaxLinks> links_{};
  link::Signing signing_;
};

}  // namespace flotilla::app
