// SPDX-License-Identifier: MIT
// What Fleet is told from Python, checked: TypeError or ValueError says what was wanted.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <string>

#include "fleet/clock.hpp"
#include "fleet/fleet.hpp"
#include "fleet/navigation_unit.hpp"
#include "fleet/radio_link.hpp"

namespace flotilla::fleet {

/// (rate_hz, message, attitude_rate_hz) and, where not the default, origin.
UnitSettings unit_from(const nanobind::tuple& unit);
/// (offset_us, drift_ppm)
Clock clock_from(const nanobind::tuple& clock);
LinkQuality quality_from(double delay_s, double jitter_s, double loss, double rate_Bps);
/// COMMAND_LONG with up to seven parameters; the others are 0.
Order order_from(int command, const nanobind::sequence& params);
/// `esc` port, stbd or none; `value` as the kind has it.
Fault fault_from(const std::string& kind, double value, const nanobind::object& esc,
                 std::uint64_t seed);
std::int64_t time_from(std::int64_t t_us);

/// `text` as what() of a ValueError.
[[noreturn]] void refuse(const std::string& text);

/// An array's elements; TypeError or ValueError where it is not C-contiguous, of T and of this shape,
/// with `name` for the argument's. T is const where it is only read. Keeps the array alive.
template <class T>
class Elements {
 public:
  Elements(nanobind::handle array, const char* name, std::size_t rows, std::size_t columns);
  T* data() const { return static_cast<T*>(array_.data()); }

 private:
  std::conditional_t<std::is_const_v<T>, nanobind::ndarray<nanobind::ro, nanobind::device::cpu>,
                     nanobind::ndarray<nanobind::device::cpu>>
      array_;
};

}  // namespace flotilla::fleet
