// SPDX-License-Identifier: MIT
#include "linux/files/parameter_saver.hpp"

#include <exception>
#include <utility>

#include "linux/files/parameter_file.hpp"
#include "linux/system/background_thread.hpp"

namespace flotilla::target {

ParameterSaver::ParameterSaver(std::filesystem::path file, std::vector<std::string> unknown)
    : file_(std::move(file)),
      unknown_(std::move(unknown)),
      thread_(start_background_thread(&ParameterSaver::run, this, "the parameter saver")) {}

bool ParameterSaver::save(const app::Parameters& values, app::SaveRequest why) {
  if (state_.load(std::memory_order_acquire) != kIdle) return false;
  values_ = values;
  saved_ = {why, std::nullopt};
  state_.store(kWork, std::memory_order_release);
  state_.notify_one();
  return true;
}

std::optional<ParameterSaver::Saved> ParameterSaver::outcome() {
  if (state_.load(std::memory_order_acquire) != kDone) return std::nullopt;
  std::optional<Saved> saved(std::move(saved_));
  state_.store(kIdle, std::memory_order_release);
  state_.notify_one();
  return saved;
}

void ParameterSaver::finish() {
  if (!running_) return;
  running_ = false;
  state_.wait(kWork, std::memory_order_acquire);
  const int last = state_.exchange(kEnd, std::memory_order_acq_rel);
  state_.notify_one();
  pthread_join(thread_, nullptr);
  state_.store(last, std::memory_order_release);  // keeps an outcome not yet taken
}

void* ParameterSaver::run(void* self) {
  auto& saver = *static_cast<ParameterSaver*>(self);
  for (;;) {
    const int state = saver.state_.load(std::memory_order_acquire);
    if (state == kEnd) return nullptr;
    if (state == kWork) {
      saver.write();
    } else {
      saver.state_.wait(state, std::memory_order_acquire);
    }
  }
}

void ParameterSaver::write() {
  try {
    saved_.fault = save_parameters(file_, values_, unknown_);
  } catch (const std::exception& error) {
    saved_.fault = std::string("parameters are not saved: ") + error.what();
  }
  state_.store(kDone, std::memory_order_release);
  state_.notify_all();
}

}  // namespace flotilla::target
