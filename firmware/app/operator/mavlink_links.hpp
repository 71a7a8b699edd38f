// SPDX-License-Identifier: MIT
// The boat's MAVLink links: a decoder, an encoder and this tick's outgoing bytes for each.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "app/operator/token_bucket.hpp"
#include "link/mavlink/decode.hpp"
#include "link/mavlink/encode.hpp"
#include "link/mavlink/signing.hpp"

namespace flotilla::app {

/// Of any boat.
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

/// What one link says in a tick: as much as no network cuts up.
using Datagram = std::array<std::uint8_t, 1400>;

class MavlinkLinks {
 public:
  /// What is kept of one link.
  struct Link {
    link::MavlinkDecoder decoder;
    link::MavlinkEncoder encoder;
    std::size_t size = 0;                       // of what is said
    std::array<std::uint8_t, 400> forwarded{};  // the rest of the tick is our own
    std::size_t forwarded_size = 0;
    std::array<std::optional<std::uint8_t>, 8> beats{};  // sequence numbers of the last heartbeats
    std::size_t next_beat = 0;
    std::optional<std::int64_t> waiting_us;  // since when a message is incomplete
    SigningPolicy policy = SigningPolicy::kOff;
    TokenBucket bucket;
  };

  /// One link for each of `links`, at most kMaxLinks. What is said goes to `out`, one a link;
  /// `signing` is room for who signs what is heard. All of it outlives this.
  MavlinkLinks(link::Address self, std::span<Link> links, std::span<Datagram> out,
               std::span<link::Signing::Stream> signing = {})
      : links_(links), out_(out), signing_(signing) {
    std::ranges::fill(links_, Link{});
    rename(self);
  }

  std::size_t count() const { return links_.size(); }

  link::MavlinkDecoder& decoder(std::size_t link) { return links_[link].decoder; }

  /// To be called when next() has returned nothing. What waits behind a whole message has come with
  /// it or later; behind a false beginning it may be as old as that.
  void note_waiting(std::size_t link, bool heard, std::int64_t now_us) {
    Link& l = links_[link];
    if (!l.decoder.waits()) {
      l.waiting_us.reset();
    } else if (heard || !l.waiting_us) {
      l.waiting_us = now_us;
    }
  }

  /// The rest of a message has not come for so long that it will not.
  bool waits_in_vain(std::size_t link, std::int64_t now_us) const {
    const auto& since_us = links_[link].waiting_us;
    return since_us && now_us - *since_us > kPatience_us;
  }

  link::Signing& signing() { return signing_; }
  const link::Signing& signing() const { return signing_; }

  /// Without a key in signing() no message counts as signed.
  void set_policy(std::size_t link, SigningPolicy policy) { links_[link].policy = policy; }

  /// The next message that this link's policy lets through.
  std::optional<link::Received> next(std::size_t link, link::Counters& counters) {
    std::optional<link::Received> received(std::in_place);
    if (!next(link, *received, counters)) received.reset();
    return received;
  }

  /// The same into `out`; false where there is none.
  bool next(std::size_t link, link::Received& out, link::Counters& counters) {
    Link& l = links_[link];
    while (l.decoder.next(out, counters, signing_of(l))) {
      const bool radio = std::holds_alternative<link::RadioStatus>(out.message);
      if (l.policy != SigningPolicy::kRequired || out.is_signed || radio) return true;
      ++counters.mavlink_unsigned_refused;
    }
    return false;
  }

  TokenBucket& bucket(std::size_t link) { return links_[link].bucket; }
  const TokenBucket& bucket(std::size_t link) const { return links_[link].bucket; }

  /// Bytes that still fit into this tick's output.
  std::size_t room(std::size_t link) const { return Datagram{}.size() - links_[link].size; }

  /// The same of the link that has least.
  std::size_t least_room() const {
    std::size_t least = Datagram{}.size();
    for (std::size_t link = 0; link < count(); ++link) least = std::min(least, room(link));
    return least;
  }

  /// A message that finds no room waits for nobody: it is dropped whole and counted.
  void send(std::size_t link, const link::Message& message, link::Counters& counters) {
    links_[link].bucket.spend_on_rest(put(link, message, counters));
  }

  /// The same for what followers steer by.
  void send_state(std::size_t link, const link::Message& message, link::Counters& counters) {
    links_[link].bucket.spend_on_state(put(link, message, counters));
  }

  void broadcast(const link::Message& message, link::Counters& counters) {
    for (std::size_t link = 0; link < count(); ++link) send(link, message, counters);
  }

  /// Another's frame, unchanged, with the next tick.
  void forward(std::size_t link, std::span<const std::uint8_t> frame, link::Counters& counters) {
    Link& l = links_[link];
    if (frame.size() > l.forwarded.size() - l.forwarded_size || !l.bucket.for_rest()) {
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
    for (std::size_t i = 0; i < count(); ++i) {
      send(i, heartbeat, counters);
      Link& link = links_[i];
      link.beats[link.next_beat++ % link.beats.size()] = link.encoder.last_sequence();
    }
  }

  /// Under another system id from now on.
  void rename(link::Address self) {
    for (Link& link : links_) link.encoder.rename(self);
  }

  std::span<const std::uint8_t> bytes(std::size_t link) const {
    return std::span(out_[link]).first(links_[link].size);
  }

  /// Begins a tick, dt_us after the one before.
  void begin(std::int64_t dt_us) {
    for (std::size_t i = 0; i < count(); ++i) {
      Link& link = links_[i];
      if (link.forwarded_size > 0) {
        std::copy_n(link.forwarded.begin(), link.forwarded_size, out_[i].begin());
      }
      link.size = std::exchange(link.forwarded_size, 0);
      link.bucket.spend_on_rest(link.size);
      link.bucket.earn(dt_us);
    }
  }

 private:
  static constexpr std::int64_t kPatience_us = 300'000;  // the longest message at 9600 Bd

  /// Its size; 0 where there was no room.
  std::size_t put(std::size_t link, const link::Message& message, link::Counters& counters) {
    Link& l = links_[link];
    const std::size_t size = l.encoder.encode(message, std::span(out_[link]).subspan(l.size),
                                              signing_of(l), static_cast<std::uint8_t>(link));
    l.size += size;
    if (size == 0) ++counters.mavlink_not_sent;
    return size;
  }

  link::Signing* signing_of(const Link& link) {
    return link.policy == SigningPolicy::kOff || !signing_.has_key() ? nullptr : &signing_;
  }

  std::span<Link> links_;
  std::span<Datagram> out_;
  link::Signing signing_;
};

}  // namespace flotilla::app
