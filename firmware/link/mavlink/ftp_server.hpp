// SPDX-License-Identifier: MIT
// MAVLink FTP, read only: clients list and download a fixed set of files, all in the root.
// Source: mavlink.io, services, File Transfer Protocol; its gaps are filled by clients' practice.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "link/mavlink/messages.hpp"
#include "link/mavlink/packed_text.hpp"

namespace flotilla::link {

struct FtpFile {
  std::string_view name;  ///< without "/", up to 200 characters
  PackedText content;
};

/// A parsed request with its path resolved.
struct FtpRequest {
  static constexpr std::uint8_t kNoFile = 255;
  std::uint16_t seq = 0;
  std::uint8_t session = 0;
  std::uint8_t opcode = 0;
  std::uint8_t size = 0;        ///< of the requested data, or of the path
  std::uint8_t file = kNoFile;  ///< index of the file at the path
  bool root = false;            ///< the path names the root
  std::uint32_t offset = 0;
};

/// Each request causes at most one packet, except a burst. A request repeated because its answer
/// was lost gets the same answer, since no answer depends on earlier ones. Link and address
/// identify a client. With too many clients or sessions, the least recently used is dropped and
/// must restart.
class FtpServer {
 public:
  /// At most 255 files, which must outlive the server.
  explicit FtpServer(std::span<const FtpFile> files) : files_(files) {}

  /// Takes a request and queues the answer, if any. Every request but a read ends the client's
  /// burst: some clients read missing parts while the burst goes on.
  void request(std::size_t link, Address from, const FtpRequest& request, std::int64_t now_us);
  void request(std::size_t link, Address from, const FileTransferProtocol& message,
               std::int64_t now_us) {
    request(link, from, read(message), now_us);
  }

  /// Parses a packet, which request() may take later.
  FtpRequest read(const FileTransferProtocol& message) const;

  /// True if no packet is due for any link.
  bool is_idle() const { return idle_; }

  /// The next packet due for that link, its clients in turn, if any. Call it while there is room.
  std::optional<FileTransferProtocol> next(std::size_t link);

 private:
  static constexpr std::size_t kClients = 8;
  static constexpr std::size_t kAnswers = 8;  // a client may request all its gaps at once
  static constexpr std::size_t kSessions = 8;
  static constexpr std::ptrdiff_t kSessionsPerClient = 2;
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min();

  struct Peer {
    std::uint8_t link = 255;
    Address address{};
    bool operator==(const Peer&) const = default;
  };

  /// A file that a client has opened under a session number of its own choice.
  struct Session {
    Peer peer{};
    std::uint8_t number = 0;
    std::uint8_t file = FtpRequest::kNoFile;
    std::int64_t used_us = kNever;
  };

  /// A queued answer; its data are filled in when it is sent.
  struct Answer {
    std::uint16_t seq = 0;
    std::uint8_t session = 0;
    std::uint8_t asked = 0;  ///< opcode of the request
    std::uint8_t error = 0;  ///< 0: none
    std::uint8_t size = 0;   ///< of the requested data
    std::uint8_t file = FtpRequest::kNoFile;
    std::uint32_t offset = 0;
  };

  struct Client {
    Peer peer{};
    std::int64_t used_us = kNever;
    std::uint64_t served = 0;  ///< serial number of its latest packet
    std::array<Answer, kAnswers> answers{};
    std::uint8_t first = 0, count = 0;
    std::optional<Answer> burst{};

    bool waits() const { return count > 0 || burst.has_value(); }
  };

  Client& client_of(const Peer& peer, std::int64_t now_us);
  Answer answer_to(const FtpRequest& request, const Peer& peer, std::int64_t now_us);
  /// These four return the error.
  std::uint8_t carry_out(Answer& answer, const FtpRequest& request, const Peer& peer,
                         std::int64_t now_us);
  std::uint8_t open(const Peer& peer, Answer& answer, const FtpRequest& request,
                    std::int64_t now_us);
  std::uint8_t read(const Peer& peer, Answer& answer, std::int64_t now_us);
  std::uint8_t list(const FtpRequest& request) const;

  Session* session_of(const Peer& peer, std::uint8_t number);
  Session& place_for(const Peer& peer, std::uint8_t number);
  std::uint8_t find(std::string_view path) const;
  FileTransferProtocol packet(const Answer& answer, Address target) const;
  std::uint8_t put_entries(std::uint32_t first, std::span<std::uint8_t> data) const;

  std::span<const FtpFile> files_;
  std::array<Client, kClients> clients_{};
  std::array<Session, kSessions> sessions_{};
  std::uint64_t served_ = 0;
  bool idle_ = true;
};

}  // namespace flotilla::link
