// SPDX-License-Identifier: MIT
// The boat's MAVLink links: a decoder, an encoder and this tick's outgoing bytes for each.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string_view>

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

  /// A message that finds no room waits for nobody: it is dropped whole and counted.
  void send(std::size_t link, const link::Message& message, link::Counters& counters) {
    Link& l = links_[link];
    const std::size_t size = l.encoder.encode(message, std::span(l.bytes).subspan(l.size),
                                              signing_of(l), static_cast<std::uint8_t>(link));
    l.size += size;
    l.credit -= static_cast<std::int64_t>(size) * kSecond_us;
    if (size == 0) ++counters.mavlink_not_sent;
  }

  void broadcast(const link::Message& message, link::Counters& counters) {
    for (std::size_t link = 0; link < count_; ++link) send(link, message, counters);
  }

  /// Messages that belong together; a link that has no credit left passes them over.
  void broadcast_telemetry(std::initializer_list<link::Message> messages,
                           link::Counters& counters) {
    for (std::size_t link = 0; link < count_; ++link) {
      if (links_[link].rate_Bps != 0 && links_[link].credit <= 0) continue;
      for (const link::Message& message : messages) send(link, message, counters);
    }
  }

  std::span<const std::uint8_t> bytes(std::size_t link) const {
    return {links_[link].bytes.data(), links_[link].size};
  }

  /// Begins a tick, dt_us after the one before.
  void begin(std::int64_t dt_us) {
    for (Link& link : links_) {
      link.size = 0;
      // Half a second's worth may be saved up.
      const std::int64_t most = std::int64_t{link.rate_Bps} * kSecond_us / 2;
      const std::int64_t earned = std::int64_t{link.rate_Bps} * std::min(dt_us, kSecond_us);
      link.credit = std::min(link.credit + earned, most);
    }
  }

 private:
  struct Link {
    link::MavlinkDecoder decoder;
    link::MavlinkEncoder encoder;
    std::array<std::uint8_t, 1024> bytes{};
    std::size_t size = 0;
    SigningPolicy policy = SigningPolicy::kOff;
    std::uint32_t rate_Bps = 0;
    std::int64_t credit = 0;  // bytes × 10⁶
  };
  static constexpr std::int64_t kSecond_us = 1'000'000;

  link::Signing* signing_of(const Link& link) {
    return link.policy == SigningPolicy::kOff || !signing_.has_key() ? nullptr : &signing_;
  }

  std::size_t count_;
  std::array<Link, kMaxLinks> links_{};
  link::Signing signing_;
};

}  // namespace flotilla::app
