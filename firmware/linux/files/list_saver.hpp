// SPDX-License-Identifier: MIT
// Saves a list in a file while the boat sails: only a background thread waits for the disk.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <exception>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "linux/files/durable_file.hpp"
#include "linux/system/first_error.hpp"
#include "linux/system/repeating_thread.hpp"

namespace flotilla::target {

template <class Item>
class ListSaver {
 public:
  using Text = std::function<std::string(std::span<const Item>)>;

  /// text: gives the file's content. every: the interval at which the file is written if the items
  /// have changed or the last write failed. Throws std::system_error that names `whose` if the
  /// thread cannot be started.
  ListSaver(std::filesystem::path path, std::size_t most_items, Text text,
            std::chrono::milliseconds every, const char* whose)
      : path_(std::move(path)), text_(std::move(text)), writer_(every, [this] { write(); }, whose) {
    const std::scoped_lock lock(mutex_);
    items_.reserve(most_items);
  }

  /// Sets the items to save. Never blocks; false: try again.
  bool put(std::span<const Item> items) {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock) return false;
    items_.assign(items.begin(), items.end());
    changed_ = true;
    return true;
  }

  /// The first error with the file, once. Writing is retried.
  std::optional<std::string> error() { return error_.take(); }

  /// The last write failed.
  bool failed() const { return failed_; }

 private:
  void write() {
    try {
      std::string text;
      {
        const std::scoped_lock lock(mutex_);
        if (!std::exchange(changed_, false)) return;
        text = text_(items_);
      }
      const auto fault = replace_file(path_, text);
      failed_ = fault.has_value();
      if (!fault) return;
      error_.put(*fault);
    } catch (const std::exception& error) {  // out of memory: retried as well
      error_.put(error.what());
      failed_ = true;
    }
    const std::scoped_lock lock(mutex_);
    changed_ = true;
  }

  std::filesystem::path path_;
  Text text_;
  std::mutex mutex_;  // of the next two; never held during a write
  std::vector<Item> items_;
  bool changed_ = false;
  std::atomic<bool> failed_ = false;
  FirstError error_;
  RepeatingThread writer_;
};

}  // namespace flotilla::target
