// SPDX-License-Identifier: MIT
// Monitors the boat's own model while it sails: which numbers look wrong, and since when.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "app/parameters.hpp"
#include "core/estimation/model_error.hpp"

namespace flotilla::app {

/// In float for every law: products of its variances are below Q16's resolution.
class ModelMonitor {
 public:
  enum class Number : std::uint8_t { kBalance, kDrag, kYawDamping };
  static constexpr std::size_t kNumbers = 3, kOfModels = 14;

  struct Finding {
    Number number = Number::kBalance;
    float value = 0;  ///< THR_BALANCE that fits; or the factor of VES_D11, VES_D33
    std::int64_t since_us = 0;
  };

  /// A change of the hull's or the propellers' numbers, or of LEARN_APPLY, discards the estimates.
  /// r_max_radps: greatest yaw rate of the law, 0: no limit.
  void configure(const Parameters& p, float r_max_radps);

  /// The parameters with the corrections that LEARN_APPLY has applied so far.
  Parameters applied(const Parameters& p) const;

  /// take() is for impulses that last for at least this long.
  static constexpr float kSample_s = 0.1F;

  /// Takes the impulse given since the last call, and the velocity, the heading and the estimated
  /// current at its end. True if applied() has changed.
  [[nodiscard]] bool take(const core::Impulse<float>& given, const core::Nu<float>& nu,
                          const core::SinCos<float>& heading, const core::Vec2<float>& current_n,
                          std::int64_t now_us);

  /// Call while the law does not drive, or the motion is unknown.
  void interrupt();

  /// A number that looks wrong: once, and again after a change that is worth reporting.
  std::optional<Finding> take_finding();

  /// The number's value while it looks wrong or is being applied.
  std::optional<float> told(Number number) const;

 private:
  struct Judged {
    float value = 0;  ///< THR_BALANCE's change, or the share beyond the parameter
    bool wrong = false, fresh = false;
    std::optional<std::int64_t> since_us;
    float told = 0;
  };

  void judge(Number number, const core::Share<float>& error, float beyond, std::int64_t now_us);
  bool apply();
  float value_of(Number number) const;

  core::ModelErrorParams<float> params_{};
  core::ModelError<float> state_{};
  std::array<Judged, kNumbers> judged_{};
  std::array<float, kOfModels> numbers_{};  // LEARN_APPLY, THR_BALANCE, hull, propellers
  float balance_applied_ = 0, drag_applied_ = 1;
};

}  // namespace flotilla::app
