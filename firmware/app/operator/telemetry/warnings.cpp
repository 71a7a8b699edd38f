// SPDX-License-Identifier: MIT
#include "app/operator/telemetry/warnings.hpp"

#include <utility>

#include "app/convert/convert_scalar.hpp"
#include "app/operator/telemetry/sentences.hpp"
#include "app/operator/telemetry/text.hpp"
#include "app/parameters/derived.hpp"

namespace flotilla::app {

namespace mav = link::mav;

template <class S>
void Warnings<S>::send(const Seen& seen) {
  if (guidance_.take_frame_warning() && frame_due_.take_if_due(seen.now_us)) {
    warn("ODOMETRY refused: frame is not north-aligned");
  }
  warn_of_host(seen);
  warn_of_vessels(seen);
  warn_of_unit(seen);
  warn_of_fast_slot(seen);
  warn_of_station(seen);
  warn_of_current(seen);
  warn_of_unsound_slot(seen);
  warn_of_depth(seen);
  warn_of_fence(seen);
  tell_latency(seen);
  tell_finding(seen);
}

template <class S>
void Warnings<S>::warn_of_host(const Seen& seen) {
  const HostReport& host = seen.host;
  if (!host.why_not_to_arm.empty() && not_to_arm_due_.take_if_due(seen.now_us))
    warn(host.why_not_to_arm);
  if (host.closed_links != 0 && closed_due_.take_if_due(seen.now_us)) {
    warn(link_is_closed(host.closed_links).text());
  }
  if (!std::exchange(save_failed_, host.save_failed) && save_failed_) {
    send_statustext(mav::kSeverityError, "parameters could not be saved: see the host's disk");
  }
  const std::string_view before = std::exchange(unsaved_list_, host.unsaved_list);
  if (before != unsaved_list_ && !unsaved_list_.empty()) {
    Sentence text;
    text << unsaved_list_ << " could not be saved: see the host's disk";
    send_statustext(mav::kSeverityError, text.text());
  }
}

template <class S>
void Warnings<S>::warn_of_vessels(const Seen& seen) {
  const auto alarm = [&](std::uint8_t system, std::string_view before, std::string_view after) {
    Sentence why;
    why << before << static_cast<float>(system) << after;
    send_statustext(mav::kSeverityCritical, why.text());
  };
  const auto doubled = guidance_.doubled(seen.now_us);
  if (doubled && double_due_.take_if_due(seen.now_us)) {
    alarm(*doubled, "two vessels use system id ", "");
  }
  const auto late = guidance_.late_neighbour(seen.now_us);
  if (late && late_due_.take_if_due(seen.now_us)) {
    alarm(*late, "vessel ", ": messages over 3 s late");
  }
}

template <class S>
void Warnings<S>::warn_of_unit(const Seen& seen) {
  if (guidance_.take_stranger() && quality_due_.take_if_due(seen.now_us)) {
    warn("navigation data ignored: disarm, or set NAV_LINK");
  }
  warn_of_time(seen);
  if ((seen.conditions & core::kOwnGood) == 0 && quality_due_.take_if_due(seen.now_us)) {
    Sentence poor;
    poor << "poor navigation: " << guidance_.own_quality().fault();
    warn(poor.text());
  }
}

/// While disarmed, warns if TIMESYNC has not determined a state's age within 2 s.
template <class S>
void Warnings<S>::warn_of_time(const Seen& seen) {
  const core::Conditions missing = ~seen.conditions & (core::kOwnTimed | core::kLeaderTimed);
  untimed_.update(missing != 0, seen.now_us);
  if (!untimed_.value() || missing == 0 || core::armed(seen.state)) return;
  if (!time_due_.take_if_due(seen.now_us)) return;
  for_each_complaint(missing, [&](std::string_view why) { warn(why); });
}

/// Warns of a slot that has been too fast for 2 s; shorter excesses are noise of the leader's
/// state.
template <class S>
void Warnings<S>::warn_of_fast_slot(const Seen& seen) {
  const auto [u, r] = convert::in_double(seen.law.too_fast);
  slot_too_fast_.update(u > 0 || r > 0, seen.now_us);
  if (!slot_too_fast_.value() || !(u > 0 || r > 0) || !fast_slot_due_.take_if_due(seen.now_us))
    return;
  const Parameters p = derived(vehicle_.parameters());
  if (u > 0) warn(slot_needs(u, " m/s, LAW_U_MAX is ", p.LAW_U_MAX).text());
  if (r > 0) warn(slot_needs(r, " rad/s, LAW_R_MAX is ", p.LAW_R_MAX).text());
}

/// Sends the figures of a lost station, one tick before the message of COAST or HOLD, which has
/// none.
template <class S>
void Warnings<S>::warn_of_station(const Seen& seen) {
  const core::StationLoss was = std::exchange(station_loss_, guidance_.station_loss());
  if (station_loss_ == was || station_loss_ == core::StationLoss::kNo || !seen.keeps_slot) return;
  const auto& e = seen.law.error.e;
  send_statustext(
      mav::kSeverityError,
      sentence_of(station_loss_, convert::number(core::hypot(e.x, e.y)),
                  convert::number(core::abs(guidance_.yaw_rate())), derived(vehicle_.parameters()))
          .text());
}

/// Reports that a boat that sails alone makes no headway, or drifts from its place, at full thrust:
/// after 2 s, or at once if it holds because it does not respond.
template <class S>
void Warnings<S>::warn_of_current(const Seen& seen) {
  const auto& e = seen.law.error.e;
  const bool was_alone = std::exchange(alone_, core::sails_alone(seen.state));
  const bool at_full_thrust = alone_ && S(0) < seen.law.allocation.missing.X;
  const bool behind =
      at_full_thrust && S(1) < core::hypot(e.x, e.y) && guidance_.motion().nu.u < S(0.05);
  no_headway_.update(behind, seen.now_us);
  const bool holds = was_alone && !alone_ && (seen.conditions & core::kBoatAnswers) == 0;
  if (!holds && !(no_headway_.value() && at_full_thrust)) return;
  if (no_headway_due_.take_if_due(seen.now_us)) {
    warn("no headway: current, wind or propellers");
  }
}

/// While armed, reports why the slot is not sound: at once, then every 10 s.
template <class S>
void Warnings<S>::warn_of_unsound_slot(const Seen& seen) {
  if ((seen.conditions & core::kSlotSound) != 0 || !core::armed(seen.state)) return;
  if (!unsound_slot_due_.take_if_due(seen.now_us)) return;
  const SlotClaims& claims = guidance_.claims();
  if (claims.leaders()) {
    send_statustext(mav::kSeverityError, "slot is at the leader: set FORM_OFS_N, FORM_OFS_E");
  } else if (const auto rival = claims.rival(seen.now_us, core::law_drives(seen.state))) {
    send_statustext(mav::kSeverityError, slot_is_taken(*rival).text());
  } else {
    send_statustext(mav::kSeverityError,
                    "slot moves astern inside the turn: move it nearer or behind the leader");
  }
}

/// Warns that an armed boat is deeper in the tree than certified: at arming, or when it learns this
/// later.
template <class S>
void Warnings<S>::warn_of_depth(const Seen& seen) {
  const std::size_t depth = guidance_.tree_place().depth(seen.now_us);
  const auto most = vehicle_.configuration().formation.max_depth;
  const bool deep = core::armed(seen.state) && most && *most < depth;
  if (std::exchange(deep_, deep) || !deep) return;
  warn(too_deep(depth, vehicle_.parameters().FORM_DEPTH).text());
}

/// In MANUAL the driver is responsible for the fence: the boat warns, and the thrust continues.
template <class S>
void Warnings<S>::warn_of_fence(const Seen& seen) {
  if (seen.state != core::State::kManual || (seen.conditions & core::kInsideFence) != 0) return;
  if (!fence_due_.take_if_due(seen.now_us)) return;
  const bool ahead = !seen.fence.stays() && !seen.fence.is_outside();
  warn(ahead ? "fence ahead, or position unknown" : "outside fence, or position unknown");
}

/// Reports a newly estimated latency of 0.03 s or more, and whether it is compensated.
template <class S>
void Warnings<S>::tell_latency(const Seen& seen) {
  constexpr double kWorthAWord_s = 0.03;
  const auto latency_s = guidance_.latency_s();
  const bool told = std::exchange(latency_told_, latency_s.has_value());
  if (told || !latency_s || *latency_s < kWorthAWord_s) return;
  const bool borne = (guidance_.conditions(seen.now_us) & core::kOwnPrompt) != 0;
  vehicle_.texts().send(mav::kSeverityWarning,
                        {unit_is_late(*latency_s).text(), borne ? ": compensated" : ""}, counters_);
}

template <class S>
void Warnings<S>::tell_finding(const Seen& seen) {
  const auto finding = learnt_.take_finding();
  if (!finding) return;
  warn(sentence_of(*finding, vehicle_.parameters().THR_BALANCE, seen.now_us, seen.host.unix_us)
           .text());
}

template <class S>
void Warnings<S>::tell_waiting(std::optional<std::uint8_t> late) {
  if (std::exchange(awaited_, late) != late) warn(waiting_for(late).text());
}

template class Warnings<float>;
template class Warnings<double>;
template class Warnings<core::Q16>;

}  // namespace flotilla::app
