// SPDX-License-Identifier: MIT
// Converts and checks Fleet's arguments from Python; TypeError or ValueError states what is
// allowed.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <string>

#include "fleet/clock.hpp"
#include "fleet/fleet.hpp"
#include "fleet/navigation_unit.hpp"
#include "fleet/radio_link.hpp"

namespace flotilla::fleet {

/// (rate_hz, message, attitude_rate_hz), optionally with origin and faults.
UnitSettings unit_from(const nanobind::tuple& unit);
/// (offset_us, drift_ppm)
Clock clock_from(const nanobind::tuple& clock);
LinkQuality quality_from(double delay_s, double jitter_s, double loss, double rate_Bps);
/// COMMAND_LONG with up to seven parameters; the others are 0.
Order order_from(int command, const nanobind::sequence& params);
/// `esc`: port, stbd or none; `value`: in the kind's unit.
Fault fault_from(const std::string& kind, double value, const nanobind::object& esc,
                 std::uint64_t seed);
std::int64_t time_from(std::int64_t t_us);

/// Throws a ValueError with `text`.
[[noreturn]] void refuse(const std::string& text);

/// An array's elements. TypeError or ValueError, with the argument's `name`, unless it is
/// C-contiguous, of T and of this shape. T is const for read-only arrays. Keeps the array alive.
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
