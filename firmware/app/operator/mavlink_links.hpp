// SPDX-License-Identifier: MIT
// The boat's MAVLink links, each with a decoder, an encoder and this tick's outgoing bytes.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "app/operator/requests/commands.hpp"
#include "app/operator/telemetry/token_bucket.hpp"
#include "link/mavlink/decode.hpp"
#include "link/mavlink/encode.hpp"
#include "link/mavlink/signing.hpp"

namespace flotilla::app {

/// Greatest number of links of any boat.
constexpr std::size_t kMaxLinks = 4;

/// How a link handles signatures.
enum class SigningPolicy : std::uint8_t {
  kOff,       ///< sends unsigned, ignores signatures
  kAccept,    ///< sends signed; accepts unsigned messages, rejects wrong signatures
  kRequired,  ///< sends signed; accepts and forwards nothing unsigned but a radio's RADIO_STATUS
};

/// The policy with that name in a configuration.
constexpr std::optional<SigningPolicy> signing_policy(std::string_view name) {
  if (name == "off") return SigningPolicy::kOff;
  if (name == "accept") return SigningPolicy::kAccept;
  if (name == "required") return SigningPolicy::kRequired;
  return std::nullopt;
}

/// One link's output in a tick. Hosts with datagrams cut it between messages.
using Datagram = std::array<std::uint8_t, 1400>;
/// Bytes of a datagram to keep free for heartbeat and state.
constexpr std::size_t kOwnRoom = 250;

class MavlinkLinks {
 public:
  struct Link {
    link::MavlinkDecoder decoder;
    link::MavlinkEncoder encoder;
    std::size_t size = 0;                       // bytes of output so far
    std::array<std::uint8_t, 400> forwarded{};  // the rest of the datagram is for our own messages
    std::size_t forwarded_size = 0;
    std::array<std::optional<std::uint8_t>, 8> beats{};  // sequence numbers of our last heartbeats
    std::size_t next_beat = 0;
    std::optional<std::int64_t> waiting_us;  // since when a message has been incomplete
    std::uint32_t whole = 0;                 // decoder.whole() at the last look
    SigningPolicy policy = SigningPolicy::kOff;
    bool datagrams = false;  // not a serial line, so no radio is on it
    bool own_last = true;    // our own message was the last one paid by the rest's credit
    bool others_next = false;
    TokenBucket bucket;
  };

  /// Uses one element of `links` for each link, at most kMaxLinks. Output goes to `out`, one
  /// datagram a link; `signing` holds the senders' signing streams. All must outlive this object.
  MavlinkLinks(link::Address self, std::span<Link> links, std::span<Datagram> out,
               std::span<link::Signing::Stream> signing = {})
      : links_(links), out_(out), signing_(signing, stops_boat) {
    std::ranges::fill(links_, Link{});
    rename(self);
  }

  std::size_t count() const { return links_.size(); }

  /// Takes bytes received on this link and returns how many: at least one after next() returned
  /// false.
  std::size_t fill(std::size_t link, std::span<const std::uint8_t> bytes) {
    return links_[link].decoder.fill(bytes);
  }

  /// The next message that this link's policy accepts, into `out`; false if there is none.
  bool next(std::size_t link, link::Received& out, std::int64_t now_us, link::Counters& counters) {
    Link& l = links_[link];
    while (l.decoder.has_bytes() && l.decoder.next(out, counters, signing_of(l))) {
      if (l.policy != SigningPolicy::kRequired || out.is_signed || is_from_radio(link, out))
        return true;
      ++counters.mavlink_unsigned_refused;
    }
    note_waiting(l, now_us);
    return false;
  }

  /// Whether this is a telemetry radio's RADIO_STATUS, on the serial line it is connected to.
  bool is_from_radio(std::size_t link, const link::Received& received) const {
    return std::holds_alternative<link::RadioStatus>(received.message) &&
           received.from.component == link::mav::kComponentRadio && !links_[link].datagrams;
  }

  /// The bytes of the message that next() returned last.
  std::span<const std::uint8_t> frame(std::size_t link) const {
    return links_[link].decoder.frame();
  }

  /// Call if the rest of an incomplete message will not come; next() then searches the bytes after
  /// its first one. False if there is none.
  bool give_up(std::size_t link, link::Counters& counters) {
    link::MavlinkDecoder& decoder = links_[link].decoder;
    if (!decoder.has_bytes()) return false;
    decoder.give_up(counters);
    return true;
  }

  /// Whether a message has been incomplete for too long for its rest to arrive.
  bool timed_out(std::size_t link, std::int64_t now_us) const {
    const auto& since_us = links_[link].waiting_us;
    return since_us && now_us - *since_us > kPatience_us;
  }

  link::Signing& signing() { return signing_; }
  const link::Signing& signing() const { return signing_; }

  /// Without a key in signing(), no message counts as signed.
  void set_policy(std::size_t link, SigningPolicy policy) { links_[link].policy = policy; }
  SigningPolicy policy(std::size_t link) const { return links_[link].policy; }
  void set_datagrams(std::size_t link) { links_[link].datagrams = true; }

  /// Whether our own messages other than state may be sent now. On a slow link they take turns with
  /// the frames of other senders: if one of those was refused after a message of ours, ours wait
  /// until one is forwarded, or half a second's credit is saved.
  bool may_send_rest(std::size_t link) const {
    const Link& l = links_[link];
    return l.others_next ? l.bucket.rest_is_full() : l.bucket.for_rest();
  }

  TokenBucket& bucket(std::size_t link) { return links_[link].bucket; }
  const TokenBucket& bucket(std::size_t link) const { return links_[link].bucket; }

  /// Bytes left in this tick's output.
  std::size_t room(std::size_t link) const { return Datagram{}.size() - links_[link].size; }

  /// The least room() of all links.
  std::size_t least_room() const {
    std::size_t least = Datagram{}.size();
    for (std::size_t link = 0; link < count(); ++link) least = std::min(least, room(link));
    return least;
  }

  /// A message that does not fit is dropped whole and counted.
  void send(std::size_t link, const link::Message& message, link::Counters& counters) {
    links_[link].bucket.spend_on_rest(put(link, message, counters));
    links_[link].own_last = true;
  }

  /// The same for the state messages that followers need.
  void send_state(std::size_t link, const link::Message& message, link::Counters& counters) {
    links_[link].bucket.spend_on_state(put(link, message, counters));
  }

  void broadcast(const link::Message& message, link::Counters& counters) {
    for (std::size_t link = 0; link < count(); ++link) send(link, message, counters);
  }

  /// Queues another sender's frame, unchanged, for the next tick. Refuses it if this link's policy
  /// requires signatures and the frame has no good one (`is_signed`).
  void forward(std::size_t link, std::span<const std::uint8_t> frame, bool is_signed,
               link::Counters& counters) {
    Link& l = links_[link];
    if (l.policy == SigningPolicy::kRequired && !is_signed) {
      ++counters.mavlink_unsigned_refused;
      return;
    }
    const bool pays = l.bucket.for_rest();
    l.others_next = !pays && l.own_last;
    if (frame.size() > l.forwarded.size() - l.forwarded_size || !pays) {
      ++counters.mavlink_not_sent;
      return;
    }
    std::copy(frame.begin(), frame.end(), l.forwarded.data() + l.forwarded_size);
    l.forwarded_size += frame.size();
    l.own_last = false;
  }

  /// Whether a heartbeat under our own ids is our own, echoed (a link that listens for broadcasts
  /// receives its own).
  bool is_echo(const link::Received& heartbeat) const {
    for (const Link& link : links_) {
      for (const auto sequence : link.beats) {
        if (sequence == heartbeat.sequence) return true;
      }
    }
    return false;
  }

  void beat(const link::Heartbeat& heartbeat, link::Counters& counters) {
    for (std::size_t i = 0; i < count(); ++i) {
      send(i, heartbeat, counters);
      Link& link = links_[i];
      link.beats[link.next_beat++ % link.beats.size()] = link.encoder.last_sequence();
    }
  }

  void rename(link::Address self) {
    for (Link& link : links_) link.encoder.rename(self);
  }

  std::span<const std::uint8_t> bytes(std::size_t link) const {
    return std::span(out_[link]).first(links_[link].size);
  }

  /// Begins a tick, dt_us after the last one.
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

  /// Restarts the wait after each complete message, because the bytes behind it came with it or
  /// later. Bytes behind a false start may be as old as that start, so giving up a false start does
  /// not restart the wait.
  static void note_waiting(Link& l, std::int64_t now_us) {
    const bool heard = std::exchange(l.whole, l.decoder.whole()) != l.decoder.whole();
    if (!l.decoder.has_bytes()) {
      l.waiting_us.reset();
    } else if (heard || !l.waiting_us) {
      l.waiting_us = now_us;
    }
  }

  /// Size of the encoded message; 0 if there was no room.
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
