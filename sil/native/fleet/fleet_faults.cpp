// SPDX-License-Identifier: MIT
// Fleet: sets and clears faults.
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>

#include "fleet/fleet.hpp"
#include "fleet/injection.hpp"
#include "link/mavlink/mav.hpp"

namespace flotilla::fleet {
namespace {

using enum FaultKind;

constexpr std::uint8_t kComponentOnboardComputer = 191;  // lower than the navigation unit's

std::int64_t microseconds(double s) { return std::llround(1e6 * s); }

void check_time(std::int64_t shown_us) {
  if (shown_us < 0) throw std::invalid_argument("value: the clock would show a time before 0");
}

}  // namespace

template <class S>
void Fleet<S>::set_fault(std::size_t agent, const Fault& fault, std::int64_t t_us) {
  Station& s = station_of(agent);
  const std::int64_t now_us = s.clock.at(t_us);
  if (fault.kind == kOwnClock || fault.kind == kClock) {
    check_time(now_us + microseconds(fault.value));
    s.was_set = true;
  }
  const bool shifts = fault.kind == kClock || fault.kind == kRadioLate;
  if (shifts && s.has(fault.kind)) clear_fault(agent, fault, t_us);
  if (is_escs(fault.kind)) {
    boats_[agents_[agent].index].escs.set_fault(fault, now_us - s.jumped_us);
    return;
  }
  if (!s.faults) s.faults = std::make_unique<VesselFaults>();
  s.faults->set(fault);
  switch (fault.kind) {
    case kBusOff:
      return report_bus(boats_[agents_[agent].index], t_us);
    case kImpostor:
    case kOwnImpostor:
    case kOwnLateKind:
      return add_unit(s, fault);
    case kOwnPoorFix:
      return s.unit.tell_fix(false);
    case kOwnPoorEstimate:
      return s.unit.tell_estimate(false);
    case kAnchored:
    case kAnchoredLate:
    case kCrowd:
    case kAisShip:
      return s.faults->anchor(fault, s.unit.settings().origin);
    case kPilot:
      return s.unit.tell_pilot(fault.value);
    case kRadioLate:
      return delay_radio(s, fault.value);
    case kClock:
      return shift_clock(s, microseconds(fault.value), t_us);
    case kRestart:
      return restart(boats_[agents_[agent].index], t_us);
    default:
      return;
  }
}

/// A second unit beside the vessel's.
template <class S>
void Fleet<S>::add_unit(Station& s, const Fault& fault) {
  UnitSettings settings = s.unit.settings();
  if (fault.kind == kImpostor) {
    const link::Address like_it{s.system, link::mav::kComponentAutopilot};
    s.faults->set_impostor(NavigationUnit(like_it, settings));
  } else if (fault.kind == kOwnImpostor) {
    const link::Address beside{s.system, kComponentOnboardComputer};
    s.faults->set_own_impostor(NavigationUnit(beside, settings));
  } else {
    settings.message = StateMessage::kOdometry;
    settings.delay_s = fault.value;
    s.faults->set_late_kind(NavigationUnit(s.unit.self(), settings));
  }
}

template <class S>
void Fleet<S>::clear_fault(std::size_t agent, const Fault& fault, std::int64_t t_us) {
  Station& s = station_of(agent);
  if (is_escs(fault.kind)) {
    boats_[agents_[agent].index].escs.clear_fault(fault.kind, fault.esc);
    return;
  }
  if (!s.faults || !s.faults->has(fault.kind)) return;
  const double value = s.faults->value(fault.kind);
  s.faults->clear(fault.kind);
  if (fault.kind == kBusOff) report_bus(boats_[agents_[agent].index], t_us);
  if (fault.kind == kOwnPoorFix) s.unit.tell_fix(true);
  if (fault.kind == kOwnPoorEstimate) s.unit.tell_estimate(true);
  if (fault.kind == kPilot) s.unit.tell_pilot(std::nullopt);
  if (fault.kind == kRadioLate) delay_radio(s, -value);
  if (fault.kind == kClock) shift_clock(s, -microseconds(value), t_us);
  if (s.faults->none()) s.faults.reset();
}

template <class S>
void Fleet<S>::shift_clock(Station& s, std::int64_t by_us, std::int64_t t_us) {
  s.clock.offset_us += by_us;
  s.jumped_us += by_us;
  if (records_) s.run->records.host(t_us, s.number, HostEvent::kClock, s.clock.offset_us);
}

template <class S>
void Fleet<S>::delay_radio(const Station& s, double by_s) {
  for (const std::uint32_t link : s.inbox) links_[link].delay_more(by_s);
  for (const std::uint32_t link : s.outbox) links_[link].delay_more(by_s);
}

template <class S>
void Fleet<S>::report_bus(Vessel& v, std::int64_t t_us) {
  app::HostReport report;
  report.bus_up = !v.station.faults->has(kBusOff);
  v.firmware.on_host(report);
  const Station& s = v.station;
  if (records_) s.run->records.host(t_us, s.number, HostEvent::kBus, report.bus_up ? 1 : 0);
}

/// The new process exists at once, but receives nothing and is not ticked until the fault ends.
template <class S>
void Fleet<S>::restart(Vessel& v, std::int64_t t_us) {
  const app::Parameters kept = v.firmware.parameters();
  std::destroy_at(&v.firmware);
  std::construct_at(&v.firmware, kept, kLinks, app::Storage(v.room, outbox_));
  if (injects_) v.firmware.let_failures_be_injected(&judge);
  v.monitor = policies::Monitor<S>(kept);
  const Station& s = v.station;
  if (records_) s.run->records.host(t_us, s.number, HostEvent::kRestart, 0);
  if (s.faults->has(kBusOff)) report_bus(v, t_us);
}

template <class S>
void Fleet<S>::inject(Vessel& v, std::int64_t t_us) {
  const auto failure = v.firmware.take_failure();
  if (!failure) return;
  const Injection injection = injection_of(*failure);
  const std::size_t agent = v.station.agent;
  for (const FaultKind kind : injection.clears) {
    clear_fault(agent, {.kind = kind, .esc = injection.esc}, t_us);
  }
  if (injection.sets) set_fault(agent, *injection.sets, t_us);
}

template void Fleet<float>::inject(Vessel&, std::int64_t);
template void Fleet<double>::inject(Vessel&, std::int64_t);
template void Fleet<core::Q16>::inject(Vessel&, std::int64_t);
template void Fleet<float>::set_fault(std::size_t, const Fault&, std::int64_t);
template void Fleet<double>::set_fault(std::size_t, const Fault&, std::int64_t);
template void Fleet<core::Q16>::set_fault(std::size_t, const Fault&, std::int64_t);
template void Fleet<float>::clear_fault(std::size_t, const Fault&, std::int64_t);
template void Fleet<double>::clear_fault(std::size_t, const Fault&, std::int64_t);
template void Fleet<core::Q16>::clear_fault(std::size_t, const Fault&, std::int64_t);

}  // namespace flotilla::fleet
