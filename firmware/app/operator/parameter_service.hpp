// SPDX-License-Identifier: MIT
// The MAVLink parameter protocol: every answer is owed until its link has room for it, and no queue
// can overflow. What is still lost on the way, clients ask for again, one by one.
#pragma once

#include <algorithm>
#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "app/parameters.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::app {

/// A text of at most 120 characters; what exceeds them is cut off.
class Sentence {
 public:
  Sentence& operator<<(std::string_view text);
  Sentence& operator<<(float number);
  std::string_view text() const { return {characters_.data(), size_}; }

 private:
  Sentence& add_digits(std::uint32_t digits, int point);

  std::array<char, 120> characters_{};
  std::size_t size_ = 0;
};

/// What became of a PARAM_SET.
struct SetResult {
  enum class What : std::uint8_t {
    kSet,        ///< `values` has it now
    kUnchanged,  ///< it was so already
    kAskMode,    ///< nothing yet: the supervisor decides about `mode`
    kRefused,
  };
  What what = What::kRefused;
  const ParameterInfo* info = nullptr;  ///< none: nobody here knows that name
  std::uint8_t mode = 0;
  std::uint8_t error = 0;  ///< MAV_PARAM_ERROR of a refusal
  Sentence sentence{};     ///< for the operator: why a known parameter keeps its value
};

/// What of the boat decides about a PARAM_SET.
struct Standing {
  Standing(bool is_armed, std::uint8_t own_system = 0) : armed(is_armed), system(own_system) {}
  bool armed;
  std::uint8_t system;  ///< in force; 0: not known here
};

class ParameterService {
 public:
  static constexpr std::size_t kCount = kParameterList.size();

  /// PARAM_ERRORs in the order they came; one too many is left out, its asker will time out.
  struct Errors {
    std::array<link::ParamError, 8> ring{};
    std::size_t first = 0, count = 0;

    bool push(const link::ParamError& error);
    std::optional<link::ParamError> pop();
  };

  /// What a link is owed. Errors, single values and the list take turns.
  struct Owed {
    Errors errors{};
    std::bitset<kCount> values{};
    std::size_t next_value = 0;            // where the search for the next one begins
    std::size_t list_at = kCount;          // kCount: no list is asked for
    std::optional<std::size_t> refused{};  // its error has just left, its value goes next
    int turn = 0;

    std::optional<std::size_t> take_single();
    std::optional<std::size_t> take_of_list();
  };

  /// links: one each, outlives this.
  explicit ParameterService(std::span<Owed> links) : links_(links) {
    std::ranges::fill(links_, Owed{});
  }

  static bool knows(const link::ParamSet& asked);
  static bool asks_for_mode(const link::ParamSet& asked);

  /// Every parameter, from the first one on; asked again, from the first one on again.
  void list(std::size_t link);

  void read(std::size_t link, link::Address from, const link::ParamRequestRead& asked);

  /// Carries it out where that is allowed, and answers every link with the value then in force.
  /// A mode is left to the supervisor: announce() or refuse() it when the decision is known.
  SetResult set(std::size_t link, link::Address from, const link::ParamSet& asked,
                Parameters& values, Standing boat);

  /// The value in force goes to every link.
  void announce(const ParameterInfo& info);

  /// The same, and before it the error to who asked.
  void refuse(std::size_t link, link::Address to, const ParameterInfo& info, std::uint8_t error);

  /// Whether next() has something for that link.
  bool owes(std::size_t link) const;

  /// The next PARAM_ERROR or PARAM_VALUE due on that link, which counts as sent.
  std::optional<link::Message> next(std::size_t link, const Parameters& values);

 private:
  static std::optional<link::Message> take_turn(Owed& owed, const Parameters& values);

  std::span<Owed> links_;
};

}  // namespace flotilla::app
