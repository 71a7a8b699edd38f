// SPDX-License-Identifier: MIT
#include "linux/files/saved_parameters.hpp"

#include <algorithm>
#include <utility>

namespace flotilla::target {
namespace {

// Minimum interval of saves, so that not every step of a slider is written.
constexpr std::int64_t kSaveEvery_us = 1'000'000;

}  // namespace

SavedParameters::SavedParameters(const std::filesystem::path& file)
    : file_(file),
      loaded_(load_parameters(file)),
      noted_(loaded_.values),
      saver_(file, loaded_.unknown) {}

std::optional<std::string> SavedParameters::maintain(app::SaveRequest request,
                                                     const app::Parameters& in_force,
                                                     std::int64_t now_us) {
  auto news = outcome();
  note_changes(request, in_force);
  save_changes(now_us);
  return news;
}

std::vector<std::string> SavedParameters::finish(app::SaveRequest request,
                                                 const app::Parameters& in_force) {
  std::vector<std::string> all;
  const auto add = [&](std::optional<std::string> news) {
    if (news) all.push_back(std::move(*news));
  };
  saver_.finish();
  add(outcome());
  note_changes(request, in_force);
  // An unusable file stays, for an operator to inspect, until a save is requested.
  const bool is_ours = !must_be_confirmed() && loaded_.source != ParameterSource::kPrevious;
  if (is_ours || may_save()) {
    add(saved("at exit", save_parameters(file_, loaded_.values, loaded_.unknown)));
  }
  return all;
}

/// Marks the operator's changes since the last call for saving. Overrides by the configuration are
/// not saved unless the operator asks to save all parameters in force.
void SavedParameters::note_changes(app::SaveRequest request, const app::Parameters& in_force) {
  if (request == app::SaveRequest::kNone) return;
  app::Parameters& values = loaded_.values;
  for (const app::ParameterInfo& info : app::kParameterList) {
    if (in_force.*info.member != noted_.*info.member) values.*info.member = in_force.*info.member;
  }
  if (request == app::SaveRequest::kConfirmed || app::contradiction(values)) values = in_force;
  noted_ = in_force;
  to_save_ = std::max(to_save_, request);
}

void SavedParameters::save_changes(std::int64_t now_us) {
  using app::SaveRequest;
  if (!may_save()) return;
  const bool unasked = to_save_ == SaveRequest::kChanged;
  if ((unasked || save_failed_) && now_us - saved_us_ < kSaveEvery_us) return;
  if (!saver_.save(loaded_.values, to_save_)) return;
  to_save_ = SaveRequest::kNone;
  saved_us_ = now_us;
}

/// Changes alone must not replace damaged files, whose values an operator may still read.
bool SavedParameters::may_save() const {
  const bool nothing_to_lose =
      !must_be_confirmed() || loaded_.source == ParameterSource::kFirstStart;
  return to_save_ == app::SaveRequest::kConfirmed ||
         (to_save_ == app::SaveRequest::kChanged && nothing_to_lose);
}

std::optional<std::string> SavedParameters::outcome() {
  const auto last = saver_.outcome();
  if (!last) return std::nullopt;
  if (last->fault) to_save_ = std::max(to_save_, last->why);  // to be retried
  return saved(last->why == app::SaveRequest::kConfirmed ? "on request" : "changed", last->fault);
}

std::optional<std::string> SavedParameters::saved(std::string_view why,
                                                  const std::optional<std::string>& fault) {
  const bool failed_before = std::exchange(save_failed_, fault.has_value());
  if (fault) return failed_before ? std::nullopt : fault;
  loaded_.must_be_confirmed = false;
  return "parameters saved (" + std::string(why) + ")";
}

}  // namespace flotilla::target
