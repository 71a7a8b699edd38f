// SPDX-License-Identifier: MIT
#include "link/mavlink/ftp_server.hpp"

#include <algorithm>
#include <charconv>

namespace flotilla::link {
namespace {

enum Opcode : std::uint8_t {
  kNone = 0,
  kTerminateSession = 1,
  kResetSessions = 2,
  kListDirectory = 3,
  kOpenFileRO = 4,
  kReadFile = 5,
  kCalcFileCRC32 = 14,
  kBurstReadFile = 15,
  kAck = 128,
  kNak = 129,
};

enum Error : std::uint8_t {
  kNoError = 0,
  kInvalidDataSize = 3,
  kInvalidSession = 4,
  kEndOfFile = 6,
  kUnknownCommand = 7,
  kFileNotFound = 10,
};

// Offsets in the payload
constexpr std::size_t kSeq = 0, kSession = 2, kOpcode = 3, kSize = 4, kRequestOpcode = 5,
                      kBurstComplete = 6, kOffset = 8, kData = 12;
constexpr std::uint8_t kMaxData = 239;

using Payload = decltype(FileTransferProtocol::payload);
static_assert(kData + kMaxData == Payload{}.size());

std::uint32_t number_at(const Payload& payload, std::size_t at, std::size_t bytes) {
  std::uint32_t number = 0;
  for (std::size_t i = bytes; i > 0; --i) number = (number << 8U) | payload[at + i - 1];
  return number;
}

void put_number(std::span<std::uint8_t> out, std::uint32_t number) {
  for (std::uint8_t& byte : out) {
    byte = static_cast<std::uint8_t>(number);
    number >>= 8U;
  }
}

/// The path in the data, without the leading "/" and the trailing NUL that only some clients send.
std::string_view path_in(const Payload& payload) {
  std::string_view path(reinterpret_cast<const char*>(payload.data()) + kData, payload[kSize]);
  path = path.substr(0, path.find('\0'));
  path.remove_prefix(std::min(path.find_first_not_of('/'), path.size()));
  return path;
}

/// Copies the bytes of the text that fit; returns their number.
std::uint8_t put_text(std::span<std::uint8_t> out, std::string_view text) {
  const std::size_t n = std::min(out.size(), text.size());
  std::copy_n(text.begin(), n, out.begin());
  return static_cast<std::uint8_t>(n);
}

}  // namespace

FtpRequest FtpServer::read(const FileTransferProtocol& message) const {
  const Payload& payload = message.payload;
  FtpRequest request{static_cast<std::uint16_t>(number_at(payload, kSeq, 2)),
                     payload[kSession],
                     payload[kOpcode],
                     payload[kSize],
                     FtpRequest::kNoFile,
                     false,
                     number_at(payload, kOffset, 4)};
  if (request.size > kMaxData) return request;
  const std::string_view path = path_in(payload);
  request.file = find(path);
  request.root = path.empty() || path == ".";
  return request;
}

void FtpServer::request(std::size_t link, Address from, const FtpRequest& request,
                        std::int64_t now_us) {
  // Otherwise two servers would answer each other endlessly.
  if (request.opcode == kAck || request.opcode == kNak) return;
  const Peer peer{static_cast<std::uint8_t>(link), from};
  Client& client = client_of(peer, now_us);
  const Answer answer = answer_to(request, peer, now_us);
  idle_ = false;
  if (request.opcode != kReadFile) client.burst.reset();
  if (request.opcode == kBurstReadFile && answer.error == kNoError) {
    client.burst = answer;
  } else if (client.count < kAnswers) {
    client.answers[(client.first + client.count) % kAnswers] = answer;
    ++client.count;
  }
}

std::optional<FileTransferProtocol> FtpServer::next(std::size_t link) {
  if (idle_) return std::nullopt;
  Client* client = nullptr;
  for (Client& other : clients_) {
    if (other.peer.link != link || !other.waits()) continue;
    if (client == nullptr || other.served < client->served) client = &other;
  }
  if (client == nullptr) {
    idle_ = std::ranges::none_of(clients_, &Client::waits);
    return std::nullopt;
  }
  client->served = ++served_;
  if (client->count > 0) {
    const Answer& answer = client->answers[client->first];
    client->first = static_cast<std::uint8_t>((client->first + 1) % kAnswers);
    --client->count;
    return packet(answer, client->peer.address);
  }
  Answer& burst = *client->burst;
  const FileTransferProtocol part = packet(burst, client->peer.address);
  ++burst.seq;
  burst.offset += part.payload[kSize];
  if (part.payload[kBurstComplete] != 0) client->burst.reset();
  return part;
}

FtpServer::Client& FtpServer::client_of(const Peer& peer, std::int64_t now_us) {
  Client* place = std::ranges::find(clients_, peer, &Client::peer);
  if (place == clients_.end()) {
    place = std::ranges::min_element(clients_, [](const Client& a, const Client& b) {
      return a.waits() != b.waits() ? b.waits() : a.used_us < b.used_us;
    });
    *place = Client{};
    place->peer = peer;
    place->served = served_;  // a new client is served last
  }
  place->used_us = now_us;
  return *place;
}

FtpServer::Answer FtpServer::answer_to(const FtpRequest& request, const Peer& peer,
                                       std::int64_t now_us) {
  Answer answer{static_cast<std::uint16_t>(request.seq + 1),
                request.session,
                request.opcode,
                kNoError,
                request.size,
                FtpRequest::kNoFile,
                request.offset};
  answer.error = answer.size > kMaxData ? std::uint8_t{kInvalidDataSize}
                                        : carry_out(answer, request, peer, now_us);
  return answer;
}

std::uint8_t FtpServer::carry_out(Answer& answer, const FtpRequest& request, const Peer& peer,
                                  std::int64_t now_us) {
  switch (answer.asked) {
    case kNone:
      return kNoError;
    case kTerminateSession:  // also succeeds if closed already: the first answer may be lost
      if (Session* session = session_of(peer, answer.session)) *session = Session{};
      return kNoError;
    case kResetSessions:
      std::ranges::replace_if(
          sessions_, [&](const Session& s) { return s.peer == peer; }, Session{});
      return kNoError;
    case kListDirectory:
      return list(request);
    case kOpenFileRO:
      return open(peer, answer, request, now_us);
    case kReadFile:
    case kBurstReadFile:
      return read(peer, answer, now_us);
    case kCalcFileCRC32:
      answer.file = request.file;
      return answer.file == FtpRequest::kNoFile ? kFileNotFound : kNoError;
    default:
      return kUnknownCommand;
  }
}

std::uint8_t FtpServer::list(const FtpRequest& request) const {
  if (!request.root) return kFileNotFound;
  return request.offset < files_.size() ? kNoError : kEndOfFile;
}

std::uint8_t FtpServer::open(const Peer& peer, Answer& answer, const FtpRequest& request,
                             std::int64_t now_us) {
  answer.file = request.file;
  if (answer.file == FtpRequest::kNoFile) return kFileNotFound;
  place_for(peer, answer.session) = {peer, answer.session, answer.file, now_us};
  return kNoError;
}

std::uint8_t FtpServer::read(const Peer& peer, Answer& answer, std::int64_t now_us) {
  Session* session = session_of(peer, answer.session);
  if (session == nullptr) return kInvalidSession;
  session->used_us = now_us;
  answer.file = session->file;
  if (answer.size == 0) answer.size = kMaxData;
  return answer.offset < files_[answer.file].content.size() ? kNoError : kEndOfFile;
}

FtpServer::Session* FtpServer::session_of(const Peer& peer, std::uint8_t number) {
  Session* session = std::ranges::find_if(
      sessions_, [&](const Session& s) { return s.peer == peer && s.number == number; });
  return session == sessions_.end() ? nullptr : session;
}

FtpServer::Session& FtpServer::place_for(const Peer& peer, std::uint8_t number) {
  if (Session* session = session_of(peer, number)) return *session;
  const bool own_only = std::ranges::count(sessions_, peer, &Session::peer) >= kSessionsPerClient;
  Session* oldest = nullptr;
  for (Session& session : sessions_) {
    if (own_only && session.peer != peer) continue;
    if (oldest == nullptr || session.used_us < oldest->used_us) oldest = &session;
  }
  return *oldest;
}

std::uint8_t FtpServer::find(std::string_view path) const {
  const auto file = std::ranges::find(files_, path, &FtpFile::name);
  return file == files_.end() ? FtpRequest::kNoFile
                              : static_cast<std::uint8_t>(file - files_.begin());
}

FileTransferProtocol FtpServer::packet(const Answer& answer, Address target) const {
  FileTransferProtocol message{target, {}};
  const std::span<std::uint8_t> payload = message.payload;
  const std::span<std::uint8_t> data = payload.subspan(kData);
  put_number(payload.subspan(kSeq, 2), answer.seq);
  payload[kSession] = answer.session;
  payload[kOpcode] = answer.error == kNoError ? kAck : kNak;
  payload[kRequestOpcode] = answer.asked;
  put_number(payload.subspan(kOffset, 4), answer.offset);
  if (answer.error != kNoError) {
    payload[kSize] = 1;
    data[0] = answer.error;
  } else if (answer.asked == kListDirectory) {
    payload[kSize] = put_entries(answer.offset, data);
  } else if (answer.asked == kOpenFileRO || answer.asked == kCalcFileCRC32) {
    const PackedText& content = files_[answer.file].content;
    payload[kSize] = 4;
    put_number(data.first(4), answer.asked == kOpenFileRO ? content.size() : content.crc());
  } else if (answer.asked == kReadFile || answer.asked == kBurstReadFile) {
    const PackedText& content = files_[answer.file].content;
    const std::size_t taken = content.read(answer.offset, data.first(answer.size));
    payload[kSize] = static_cast<std::uint8_t>(taken);
    const bool complete = content.size() - answer.offset <= answer.size;
    payload[kBurstComplete] = answer.asked == kBurstReadFile && complete ? 1 : 0;
  }
  return message;
}

std::uint8_t FtpServer::put_entries(std::uint32_t first, std::span<std::uint8_t> data) const {
  std::size_t length = 0;
  for (const FtpFile& file : files_.subspan(first)) {
    std::array<char, 20> digits{};
    const char* end = std::to_chars(digits.begin(), digits.end(), file.content.size()).ptr;
    const auto size = static_cast<std::size_t>(end - digits.begin());
    if (length + file.name.size() + size + 3 > data.size()) break;
    data[length++] = 'F';
    length += put_text(data.subspan(length), file.name);
    data[length++] = '\t';
    length += put_text(data.subspan(length), {digits.data(), size});
    data[length++] = '\0';
  }
  return static_cast<std::uint8_t>(length);
}

}  // namespace flotilla::link
