// SPDX-License-Identifier: MIT
// MAVLink's log protocol: lists a host's logs and sends their bytes. The host reads them from its
// disk as they are asked for. Without a host that keeps logs, the list is empty.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "link/mavlink/messages.hpp"

namespace flotilla::app {

/// One log of the host's list, the oldest first.
struct StoredLog {
  std::uint32_t size = 0;    ///< bytes
  std::uint32_t time_s = 0;  ///< of its last change, Unix time
};

/// Bytes that a client waits for.
struct LogRange {
  std::uint32_t offset = 0, end = 0;
};

/// Room for the list, for a piece of a log, and for a client's gaps.
struct LogRoom {
  std::span<StoredLog> list;
  std::span<std::uint8_t> piece;
  std::span<LogRange> ranges;
};

/// The next request to the host: its list, or a piece of a log from `offset` on.
struct LogRequest {
  bool list = false;
  std::uint16_t log = 0;  ///< index in the list
  std::uint32_t offset = 0;
  bool operator==(const LogRequest&) const = default;
};

class LogService {
 public:
  /// The room must outlive this object. from_1: ids begin with 1, as ArduPilot's do, after an empty
  /// log 0.
  LogService(const LogRoom& room, bool from_1) : room_(room), first_(from_1 ? 1 : 0) {}

  /// Call if the host keeps logs. Before, the list is empty.
  void open() { open_ = true; }

  void list(std::size_t link, const link::LogRequestList& asked);
  /// Takes a request for bytes. Returns the reason for a refusal, for the operator; empty: the
  /// bytes will be sent. A client may request all its gaps at once.
  std::string_view read(std::size_t link, const link::LogRequestData& asked);
  void end(std::size_t link);

  /// The next message for that link; nothing if none is due, or the host has not brought its data
  /// yet.
  std::optional<link::Message> next(std::size_t link);
  bool is_idle() const { return !listing_ && ranges_ == 0; }

  std::optional<LogRequest> request() const;
  /// Takes the list that was asked for; keeps the newest logs if there is no room for all.
  void bring_list(std::span<const StoredLog> logs);
  /// Index in that list of the first log kept; the older ones are left out.
  std::size_t left_out() const { return left_out_; }
  /// Takes the bytes that were asked for, as many as there is room for; no bytes: the log ends
  /// there.
  void bring(const LogRequest& request, std::span<const std::uint8_t> bytes);
  std::size_t piece_bytes() const { return room_.piece.size(); }

 private:
  /// A list that is being sent.
  struct Listing {
    std::size_t link = 0;
    std::uint32_t next = 0, last = 0;  // ids
  };

  std::uint32_t ids() const;
  link::LogEntry entry(std::uint32_t id) const;
  std::optional<link::Message> next_data();
  void pop();

  LogRoom room_;
  std::uint16_t first_;
  bool open_ = false;
  bool listed_ = false, asks_list_ = false;
  std::size_t logs_ = 0, left_out_ = 0;
  std::optional<Listing> listing_;

  std::size_t link_ = 0;  // of the ranges
  std::uint16_t log_ = 0;
  std::size_t ranges_ = 0;
  LogRequest here_;  // the piece in the room
  std::size_t here_bytes_ = 0;
};

}  // namespace flotilla::app
