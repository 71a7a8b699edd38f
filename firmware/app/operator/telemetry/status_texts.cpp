// SPDX-License-Identifier: MIT
#include "app/operator/telemetry/status_texts.hpp"

#include <algorithm>

#include "app/operator/telemetry/text.hpp"

namespace flotilla::app {

void StatusTexts::send(std::uint8_t severity, std::initializer_list<std::string_view> parts,
                       link::Counters& counters) {
  std::array<char, 200> text{};
  std::size_t length = 0;
  for (const std::string_view part : parts) {
    const std::size_t n = std::min(part.size(), text.size() - length);
    std::copy_n(part.begin(), n, text.begin() + static_cast<std::ptrdiff_t>(length));
    length += n;
  }
  link::Statustext chunk{severity, {}};
  // A NUL ends the last chunk, so a text that fills a chunk to the end needs one more.
  const bool one_chunk = length <= chunk.text.size();
  if (!one_chunk) chunk.id = ++id_ != 0 ? id_ : ++id_;
  for (std::size_t at = 0; at == 0 || (!one_chunk && at <= length); at += chunk.text.size()) {
    chunk.text = {};
    const std::size_t n = std::min(chunk.text.size(), length - at);
    std::copy_n(text.begin() + static_cast<std::ptrdiff_t>(at), n, chunk.text.begin());
    links_.broadcast(chunk, counters);
    ++chunk.chunk_seq;
  }
}

void StatusTexts::send_complaints(std::string_view what, core::Conditions unmet,
                                  link::Counters& counters) {
  constexpr std::size_t kSentenceRoom = 200;  // a sentence of two chunks
  for_each_complaint(unmet, [&](std::string_view why) {
    if (links_.least_room() < kOwnRoom + kSentenceRoom) return;
    send(link::mav::kSeverityWarning, {what, why}, counters);
  });
}

}  // namespace flotilla::app
