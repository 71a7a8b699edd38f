// SPDX-License-Identifier: MIT
#include "app/operator/services/log_service.hpp"

#include <algorithm>

namespace flotilla::app {

std::uint32_t LogService::ids() const {
  return logs_ == 0 ? 0 : static_cast<std::uint32_t>(logs_ + first_);
}

void LogService::list(std::size_t link, const link::LogRequestList& asked) {
  listing_ = Listing{link, asked.start, asked.end};
  // While a log is read, its place in the list must not change.
  if (open_ && ranges_ == 0 && (asked.start <= first_ || !listed_)) asks_list_ = true;
}

std::string_view LogService::read(std::size_t link, const link::LogRequestData& asked) {
  if (!open_) return "no logs are kept";
  const std::uint32_t log = asked.id - std::uint32_t{first_};
  if (asked.id < first_ || log >= logs_) return "no such log: list them first";
  if (link != link_ || log != log_) ranges_ = 0;
  link_ = link;
  log_ = static_cast<std::uint16_t>(log);
  const std::uint32_t size = room_.list[log].size;
  const std::uint32_t from = std::min(asked.ofs, size);
  const LogRange range{from, from + std::min(asked.count, size - from)};
  const auto contains = [&range](const LogRange& queued) {
    return queued.offset <= range.offset && range.end <= queued.end;
  };
  const auto queued = room_.ranges.first(ranges_);
  if (std::ranges::any_of(queued, contains) || ranges_ == room_.ranges.size()) return {};
  room_.ranges[ranges_++] = range;
  return {};
}

void LogService::end(std::size_t link) {
  if (link == link_) ranges_ = 0;
  if (listing_ && link == listing_->link) listing_.reset();
}

link::LogEntry LogService::entry(std::uint32_t id) const {
  link::LogEntry out{};
  out.id = static_cast<std::uint16_t>(id);
  out.num_logs = static_cast<std::uint16_t>(ids());
  out.last_log_num = static_cast<std::uint16_t>(std::max(ids(), std::uint32_t{1}) - 1);
  if (id < first_ || id - first_ >= logs_) return out;
  const StoredLog& log = room_.list[id - first_];
  out.size = log.size;
  out.time_utc = log.time_s;
  return out;
}

std::optional<link::Message> LogService::next(std::size_t link) {
  if (listing_ && listing_->link == link && !asks_list_) {
    if (ids() == 0) {
      listing_.reset();
      return link::LogEntry{};
    }
    if (listing_->next < ids() && listing_->next <= listing_->last) return entry(listing_->next++);
    listing_.reset();
  }
  return ranges_ > 0 && link == link_ ? next_data() : std::nullopt;
}

/// Answers an empty range, or one beyond the end of its log, with a message without bytes.
std::optional<link::Message> LogService::next_data() {
  LogRange& range = room_.ranges[0];
  link::LogData out{};
  out.id = static_cast<std::uint16_t>(log_ + first_);
  out.ofs = range.offset;
  const std::size_t requested = std::min<std::size_t>(out.data.size(), range.end - range.offset);
  if (requested > 0) {
    if (here_bytes_ == 0 || here_.log != log_ || range.offset < here_.offset) return std::nullopt;
    const std::size_t at = range.offset - here_.offset;
    if (at + requested > here_bytes_) return std::nullopt;
    std::copy_n(room_.piece.begin() + static_cast<std::ptrdiff_t>(at), requested, out.data.begin());
  }
  out.count = static_cast<std::uint8_t>(requested);
  range.offset += static_cast<std::uint32_t>(requested);
  if (range.offset == range.end) pop();
  return out;
}

void LogService::pop() {
  std::copy(room_.ranges.begin() + 1, room_.ranges.begin() + static_cast<std::ptrdiff_t>(ranges_),
            room_.ranges.begin());
  --ranges_;
}

std::optional<LogRequest> LogService::request() const {
  if (asks_list_) return LogRequest{true, 0, 0};
  if (ranges_ == 0) return std::nullopt;
  const LogRange& range = room_.ranges[0];
  constexpr std::uint32_t kPacket = std::tuple_size_v<decltype(link::LogData::data)>;
  const std::uint32_t requested = std::min(kPacket, range.end - range.offset);
  const bool is_here = here_bytes_ > 0 && here_.log == log_ && here_.offset <= range.offset &&
                       range.offset - here_.offset + requested <= here_bytes_;
  return requested == 0 || is_here ? std::nullopt
                                   : std::optional(LogRequest{false, log_, range.offset});
}

void LogService::bring_list(std::span<const StoredLog> logs) {
  if (!asks_list_) return;
  asks_list_ = false;
  listed_ = true;
  here_bytes_ = 0;
  left_out_ = logs.size() - std::min(logs.size(), room_.list.size());
  logs_ = logs.size() - left_out_;
  std::ranges::copy(logs.subspan(left_out_), room_.list.begin());
}

void LogService::bring(const LogRequest& request, std::span<const std::uint8_t> bytes) {
  if (this->request() != request || request.list) return;
  here_ = request;
  here_bytes_ = std::min(bytes.size(), room_.piece.size());
  std::copy_n(bytes.begin(), here_bytes_, room_.piece.begin());
  LogRange& range = room_.ranges[0];
  const auto left = static_cast<std::uint32_t>(here_bytes_);
  // The file was truncated or removed after it was listed.
  if (range.end - range.offset > left && here_bytes_ < room_.piece.size()) {
    range.end = range.offset + left;
  }
}

}  // namespace flotilla::app
