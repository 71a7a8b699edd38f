// SPDX-License-Identifier: MIT
#include "fleet_values.hpp"

#include <nanobind/stl/string.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <type_traits>
#include <utility>
#include <vector>

namespace nb = nanobind;

namespace flotilla::fleet {
namespace {

constexpr std::int64_t kLatest_us = 4'000'000'000'000'000;  // 127 years; a clock may add as much
// Longjumeau, as everywhere in the SIL; any place would do.
constexpr std::array<std::int32_t, 3> kOrigin{487'000'000, 22'950'000, 40'000};

template <class T>
T item(const nb::handle& sequence, std::size_t i, const char* desired) {
  T value{};
  if (!nb::try_cast(nb::object(sequence[i]), value)) throw nb::type_error(desired);
  return value;
}

StateMessage message_from(const std::string& name) {
  constexpr std::array<std::pair<const char*, StateMessage>, 4> kNames{
      {{"local", StateMessage::kLocal},
       {"odometry", StateMessage::kOdometry},
       {"global", StateMessage::kGlobal},
       {"follow_target", StateMessage::kFollowTarget}}};
  for (const auto& [known, message] : kNames) {
    if (name == known) return message;
  }
  refuse("unit: message is \"local\", \"odometry\", \"global\" or \"follow_target\", not \"" +
         name + "\"");
}

bool within(double x, double low, double high) { return low <= x && x <= high; }

std::array<std::int32_t, 3> origin_from(const nb::handle& origin) {
  constexpr const char* kDesired = "unit: origin is (latitude degE7, longitude degE7, altitude mm)";
  if (!nb::isinstance<nb::tuple>(origin) || nb::len(origin) != 3) throw nb::type_error(kDesired);
  const std::array out{item<std::int32_t>(origin, 0, kDesired),
                       item<std::int32_t>(origin, 1, kDesired),
                       item<std::int32_t>(origin, 2, kDesired)};
  if (std::abs(out[0]) > 900'000'000 || std::abs(std::int64_t{out[1]}) > 1'800'000'000) {
    refuse(kDesired);
  }
  return out;
}

void set_faults(UnitSettings& unit, const nb::handle& faults) {
  constexpr const char* kDesired =
      "unit: faults are (delay_s, timesync, dropout_every_s, dropout_s)";
  if (!nb::isinstance<nb::tuple>(faults) || nb::len(faults) != 4) throw nb::type_error(kDesired);
  unit.delay_s = item<double>(faults, 0, kDesired);
  unit.timesync = item<bool>(faults, 1, kDesired);
  unit.dropout_every_s = item<double>(faults, 2, kDesired);
  unit.dropout_s = item<double>(faults, 3, kDesired);
  for (const double s : {unit.delay_s, unit.dropout_every_s, unit.dropout_s}) {
    if (!within(s, 0, 1e6)) refuse("unit: delay_s, dropout_every_s, dropout_s from 0 to 1000000");
  }
}

std::string shape_text(std::span<const std::size_t> shape) {
  std::string text;
  for (const std::size_t n : shape)
    text.append(text.empty() ? "(" : ", ").append(std::to_string(n));
  return text.append(")");
}

}  // namespace

void refuse(const std::string& text) { throw nb::value_error(text.c_str()); }

UnitSettings unit_from(const nb::tuple& unit) {
  constexpr const char* kDesired =
      "unit: (rate_hz, message, attitude_rate_hz) or (rate_hz, message, attitude_rate_hz, origin) "
      "or (rate_hz, message, attitude_rate_hz, origin, faults)";
  if (unit.size() < 3 || unit.size() > 5) throw nb::type_error(kDesired);
  const double rate_hz = item<double>(unit, 0, kDesired);
  const double attitude_rate_hz = item<double>(unit, 2, kDesired);
  // A period is at least one microsecond.
  if (!within(rate_hz, 1e-3, 1e6)) refuse("unit: rate_hz from 0.001 to 1000000");
  if (attitude_rate_hz != 0 && !within(attitude_rate_hz, 1e-3, 1e6)) {
    refuse("unit: attitude_rate_hz is 0 or from 0.001 to 1000000");
  }
  UnitSettings out{rate_hz, message_from(item<std::string>(unit, 1, kDesired)), attitude_rate_hz,
                   unit.size() > 3 ? origin_from(unit[3]) : kOrigin};
  if (unit.size() > 4) set_faults(out, unit[4]);
  return out;
}

Clock clock_from(const nb::tuple& clock) {
  constexpr const char* kDesired = "clock: (offset_us, drift_ppm)";
  if (clock.size() != 2) throw nb::type_error(kDesired);
  const Clock out{item<std::int64_t>(clock, 0, kDesired), item<double>(clock, 1, kDesired)};
  if (out.offset_us < 0 || out.offset_us > kLatest_us) refuse("clock: offset_us from 0 to 4e15");
  if (!within(out.drift_ppm, -1e5, 1e5)) refuse("clock: drift_ppm from -100000 to 100000");
  return out;
}

LinkQuality quality_from(double delay_s, double jitter_s, double loss, double rate_Bps) {
  constexpr double kLongest_s = 1e6, kFastest_Bps = 1e12;
  if (!within(delay_s, 0, kLongest_s)) refuse("delay_s: from 0 to 1000000");
  if (!within(jitter_s, 0, kLongest_s)) refuse("jitter_s: from 0 to 1000000");
  if (!within(loss, 0, 1)) refuse("loss: from 0 to 1");
  if (rate_Bps != 0 && !within(rate_Bps, 1, kFastest_Bps)) refuse("rate_Bps: 0 or from 1 to 1e12");
  return {delay_s, jitter_s, loss, rate_Bps};
}

Order order_from(int command, const nb::sequence& params) {
  if (command < 0 || command > 0xFFFF) refuse("command: from 0 to 65535");
  Order order{static_cast<std::uint16_t>(command), {}};
  const std::size_t count = nb::len(params);
  if (count > order.params.size()) refuse("params: at most 7 numbers");
  for (std::size_t i = 0; i < count; ++i) {
    order.params[i] = static_cast<float>(item<double>(params, i, "params: at most 7 numbers"));
  }
  return order;
}

Fault fault_from(const std::string& kind, double value, const nb::object& esc, std::uint64_t seed) {
  const auto* const row = std::ranges::find(kFaults, kind, &FaultRow::name);
  if (row == kFaults.end()) refuse("kind: none of flotilla.fault_list() is \"" + kind + "\"");
  if (row->owner == FaultOwner::kWorld) refuse("kind: " + kind + " is not on a fleet's wires");
  const auto [least, greatest] = row->unit.empty() ? kAny : row->allowed;
  if (!within(value, least, greatest)) {
    std::array<char, 96> range{};
    std::snprintf(range.data(), range.size(), "value: a number from %g to %g", least, greatest);
    refuse(kind + ": " + range.data());
  }
  Fault out{row->kind, value, std::nullopt, seed};
  if (esc.is_none()) return out;
  std::string name;
  if (!is_escs(out.kind)) refuse("esc: only a fault of ESCs has one");
  if (!nb::try_cast(esc, name) || (name != "port" && name != "stbd")) {
    refuse("esc: \"port\", \"stbd\" or None");
  }
  out.esc = name == "port" ? 0 : 1;
  return out;
}

std::int64_t time_from(std::int64_t t_us) {
  if (t_us < 0 || t_us > kLatest_us) refuse("t_us: from 0 to 4e15");
  return t_us;
}

template <class T>
Elements<T>::Elements(nb::handle array, const char* name, std::size_t rows, std::size_t columns) {
  using Element = std::remove_const_t<T>;
  const std::string desired = std::string(name) + ": a C-contiguous" +
                              (std::is_const_v<T> ? "" : ", writable") +
                              (std::is_same_v<Element, double> ? " float64" : " int32") +
                              " array of shape " + shape_text(std::array{rows, columns});
  if (!nb::try_cast(array, array_) || array_.dtype() != nb::dtype<Element>()) {
    throw nb::type_error(desired.c_str());
  }
  if (array_.ndim() != 2 || array_.shape(0) != rows || array_.shape(1) != columns) {
    std::vector<std::size_t> shape;
    for (std::size_t i = 0; i < array_.ndim(); ++i) shape.push_back(array_.shape(i));
    refuse(desired + ", not " + shape_text(shape));
  }
  const bool contiguous =
      array_.stride(1) == 1 && (rows < 2 || std::cmp_equal(array_.stride(0), columns));
  if (rows > 0 && !contiguous) throw nb::type_error(desired.c_str());
}

template class Elements<const double>;
template class Elements<double>;
template class Elements<const std::int32_t>;

}  // namespace flotilla::fleet
