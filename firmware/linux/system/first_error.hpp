// SPDX-License-Identifier: MIT
// Passes a background thread's first error to the control loop, once.
#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace flotilla::target {

class FirstError {
 public:
  /// For the background thread; keeps only the first sentence.
  void put(std::string_view sentence) {
    if (there_.load(std::memory_order_relaxed)) return;
    sentence_ = sentence;
    there_.store(true, std::memory_order_release);
  }

  /// For the loop: returns the sentence once; never blocks or allocates.
  std::optional<std::string> take() {
    if (taken_ || !there_.load(std::memory_order_acquire)) return std::nullopt;
    taken_ = true;
    return std::move(sentence_);
  }

 private:
  std::string sentence_;
  std::atomic<bool> there_{false};
  bool taken_ = false;
};

}  // namespace flotilla::target
