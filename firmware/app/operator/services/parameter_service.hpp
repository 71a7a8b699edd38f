// SPDX-License-Identifier: MIT
// The MAVLink parameter protocol: each answer stays pending until its link has room, and no queue
// can overflow. Clients re-request answers lost on the way, one by one.
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
#include "app/sentence.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::app {

/// Result of a PARAM_SET.
struct SetResult {
  enum class Outcome : std::uint8_t {
    kSet,        ///< `values` has the new value
    kUnchanged,  ///< `values` had that value already
    kRefused,
  };
  Outcome outcome = Outcome::kRefused;
  const ParameterInfo* info = nullptr;  ///< nullptr: unknown name
  std::uint8_t error = 0;               ///< MAV_PARAM_ERROR of a refusal
  Sentence sentence{};                  ///< for the operator: why nothing was set
};

/// The boat's state that decides about a PARAM_SET.
struct Standing {
  Standing(bool is_armed, std::uint8_t own_system = 0) : armed(is_armed), system(own_system) {}
  bool armed;
  std::uint8_t system;  ///< system id in force; 0: not known here
};

class ParameterService {
 public:
  static constexpr std::size_t kCount = kParameterList.size();

  /// PARAM_ERRORs in order of arrival; when full, drops new ones: their clients time out.
  struct Errors {
    std::array<link::ParamError, 8> ring{};
    std::size_t first = 0, count = 0;

    bool push(const link::ParamError& error);
    std::optional<link::ParamError> pop();
  };

  /// Pending answers of a link. Errors, single values and the list take turns.
  struct Owed {
    Errors errors{};
    std::bitset<kCount> values{};
    std::size_t next_value = 0;            // where the search for the next one begins
    std::size_t list_at = kCount;          // kCount: no list is requested
    std::optional<std::size_t> refused{};  // parameter whose error was just sent; value is next
    int turn = 0;

    std::optional<std::size_t> take_single();
    std::optional<std::size_t> take_of_list();
  };

  /// links: one element for each link; must outlive this object.
  explicit ParameterService(std::span<Owed> links) : links_(links) {
    std::ranges::fill(links_, Owed{});
  }

  static bool knows(const link::ParamSet& asked);

  /// Sends every parameter; a repeated request starts again from the first.
  void list(std::size_t link);

  void read(std::size_t link, link::Address from, const link::ParamRequestRead& asked);

  /// Applies the set if it is allowed, and answers on every link with the value in force.
  SetResult set(std::size_t link, link::Address from, const link::ParamSet& asked,
                Parameters& values, Standing boat);

  /// Whether next() has a message for that link.
  bool owes(std::size_t link) const;

  /// The next PARAM_ERROR or PARAM_VALUE for that link; it then counts as sent.
  std::optional<link::Message> next(std::size_t link, const Parameters& values);

 private:
  /// Sends the value in force on every link.
  void announce(const ParameterInfo& info);

  /// The same, preceded by an error to the client that asked.
  void refuse(std::size_t link, link::Address to, const ParameterInfo& info, std::uint8_t error);

  static std::optional<link::Message> take_turn(Owed& owed, const Parameters& values);

  std::span<Owed> links_;
};

}  // namespace flotilla::app
