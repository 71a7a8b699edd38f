// SPDX-License-Identifier: MIT
#include "app/navigation/neighbours.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/convert/convert_place.hpp"
#include "app/convert/portable.hpp"
#include "app/navigation/clock_offset.hpp"

namespace flotilla::app {
namespace {

// No moving vessel is extrapolated longer. A vessel all of whose states seem even later is believed
// to be prompt: its clock may have been set back, or one wrong stamp may have run ahead.
constexpr std::int64_t kShipForgotten_us = 30'000'000;
constexpr std::int64_t kRestingForgotten_us = 390'000'000;  // two of its reports, and half a minute
constexpr std::int64_t kSways_us = 10'000'000;  // a resting ship is extrapolated no longer
constexpr std::uint32_t kLastSystem = 255;
// If there are more vessels than entries, those count that come nearest within this time.
constexpr double kFarSighted_s = 30;
constexpr double kOnItsWay_s = 0.1;     // least latency of the radio, and age at sending
constexpr std::int64_t kDrift = 1'000;  // no two clocks drift apart by 1/kDrift
constexpr float kDeepest = 250;

/// How near a vessel at that distance comes to our present place within kFarSighted_s, m. On the
/// microcontroller, whose image has no room for this rule: how near it is.
double nearest_m(double north_m, double east_m, double v_north_mps, double v_east_mps) {
  if constexpr (FLOTILLA_LOOKS_AHEAD != 0) {
    const double v2 = v_north_mps * v_north_mps + v_east_mps * v_east_mps;
    const double closing = -(north_m * v_north_mps + east_m * v_east_mps);
    const double t_s = v2 > 0 ? std::clamp(closing / v2, 0.0, kFarSighted_s) : 0;
    north_m += t_s * v_north_mps;
    east_m += t_s * v_east_mps;
  }
  return portable::hypot(north_m, east_m);
}

/// The distance to a hull; at least a tenth of that to its centre, or long ships around us would
/// hide a near boat.
double to_hull_m(double centre_m, float reach_m) {
  return std::max(centre_m - double{reach_m}, 0.1 * centre_m);
}

std::uint16_t milliseconds(std::int64_t us) {
  constexpr std::int64_t kMost_us = 65'535'000;
  return static_cast<std::uint16_t>(std::clamp<std::int64_t>(us, 0, kMost_us) / 1000);
}

/// A message that no other firmware sends.
bool is_ours(const link::Message& message) {
  return std::holds_alternative<link::FormationReference>(message) ||
         std::holds_alternative<link::FleetBeacon>(message);
}

bool same(const link::GpsGlobalOrigin& a, const link::GpsGlobalOrigin& b) {
  return a.latitude == b.latitude && a.longitude == b.longitude;
}

}  // namespace

void Neighbours::configure(std::uint8_t own_system, std::uint8_t leader_system, float least_m) {
  own_system_ = own_system;
  if (leader_system != leader_system_) leader_depth_.reset();
  leader_system_ = leader_system;
  least_m_ = least_m;
  watches_ = least_m > 0;
}

template <class S>
void Neighbours::take_news(const link::Received& received, const convert::Position& own,
                           std::int64_t now_us, std::optional<float> reach_m) {
  const auto [system, component] = received.from;
  if (const auto* ship = std::get_if<link::AisVessel>(&received.message)) {
    take_ais<S>(*ship, own, now_us);
  }
  if (!watches() || system == own_system_ || system == 0) return;
  if (const auto* beat = std::get_if<link::Heartbeat>(&received.message)) {
    take_heartbeat(received.from, *beat, now_us);
  } else if (is_ours(received.message)) {
    speaker_[system] = component;
  } else if (const auto* value = std::get_if<link::NamedValueFloat>(&received.message)) {
    take_depth(received.from, *value);
  }
  if (component == 0 || autopilot_[system] != component) return;
  if (const auto* origin = std::get_if<link::GpsGlobalOrigin>(&received.message)) {
    take_origin(system, *origin);
  } else if (const auto sample = convert::place_of<S>(received.message)) {
    take_place(system, *sample, reach_m, own, now_us);
  }
}

/// The component whose places are used stays the vessel's autopilot; another one gets its turn if
/// no place came between two heartbeats.
void Neighbours::take_heartbeat(link::Address from, const link::Heartbeat& message,
                                std::int64_t now_us) {
  if (!link::is_vehicle(message)) return;
  constexpr unsigned kBySelf = link::mav::kModeFlagAuto | link::mav::kModeFlagGuided;
  std::uint8_t& autopilot = autopilot_[from.system];
  const bool told = std::ranges::any_of(
      vessels_, [&](const Vessel& v) { return v.id == from.system && counts(v, now_us); });
  if (autopilot == from.component) {
    idle_[from.system] = !told;
  } else {
    if (told) return;
    if (autopilot != 0 && !idle_[from.system]) {
      idle_[from.system] = true;
      return;
    }
    autopilot = from.component;
    idle_[from.system] = false;
  }
  for (Vessel& v : vessels_) {
    if (v.id == from.system) v.steered = (message.base_mode & kBySelf) != 0;
  }
}

/// Other firmware sends the depth of the water under that name.
void Neighbours::take_depth(link::Address from, const link::NamedValueFloat& message) {
  const auto [system, component] = from;
  const float told = message.value;
  if (component == 0 || speaker_[system] != component || !link::is_text(message.name, "DEPTH"))
    return;
  if (!(told >= 0 && told <= kDeepest)) return;
  const auto depth = static_cast<std::uint8_t>(told);
  if (static_cast<float>(depth) != told) return;
  if (system == leader_system_) leader_depth_ = depth;
  for (Vessel& v : vessels_) {
    if (v.id == system) v.depth = depth;
  }
}

/// When all frames are in use, replaces those of vessels without an entry, in turn.
void Neighbours::take_origin(std::uint8_t system, const link::GpsGlobalOrigin& message) {
  if (!convert::is_valid(message)) return;
  LocalFrame* frame = std::ranges::find(local_frames_, system, &LocalFrame::system);
  while (frame == local_frames_.end()) {
    last_frame_ = (last_frame_ + 1) % local_frames_.size();
    LocalFrame& next = local_frames_[last_frame_];
    if (next.system == 0 || find(next.system) == nullptr) frame = &next;
  }
  constexpr std::int32_t kMost_m = std::numeric_limits<std::int16_t>::max();
  const auto altitude_m =
      static_cast<std::int16_t>(std::clamp(message.altitude / 1000, -kMost_m, kMost_m));
  *frame = {message.latitude, message.longitude, altitude_m, system};
}

std::optional<link::GpsGlobalOrigin> Neighbours::origin_of(std::uint32_t id) const {
  const LocalFrame* frame = std::ranges::find(local_frames_, id, &LocalFrame::system);
  if (frame == local_frames_.end()) return std::nullopt;
  return link::GpsGlobalOrigin{frame->latitude, frame->longitude, frame->altitude_m * 1000, 0};
}

/// The receiver may be our own, and repeats a report with its age.
template <class S>
void Neighbours::take_ais(const link::AisVessel& message, const convert::Position& own,
                          std::int64_t now_us) {
  const auto report = convert::ais_report_of<S>(message);
  if (!watches() || !report || message.MMSI <= kLastSystem) return;
  if (report->age_us > (report->rests ? kRestingForgotten_us : kShipForgotten_us)) return;
  convert::Sample<S> sample = report->sample;
  sample.stamp_us = now_us - report->age_us;
  const auto reach_m = static_cast<float>(convert::number(report->reach_m));
  if (Vessel* vessel = take_place(message.MMSI, sample, reach_m, own, now_us)) {
    vessel->rests = report->rests;
  }
}

template <class S>
Neighbours::Vessel* Neighbours::take_place(std::uint32_t id, const convert::Sample<S>& sample,
                                           std::optional<float> reach_m,
                                           const convert::Position& own, std::int64_t now_us) {
  const bool local = !sample.at;
  const auto origin = local ? origin_of(id) : std::optional(own.origin);
  if (!convert::is_valid(own.origin) || !origin) return nullptr;
  const convert::Sample<S> seen = local ? sample : convert::in_plane(sample, own.origin);
  const convert::Position there{seen.north_m, seen.east_m, *origin};
  if (!convert::near(own, there)) return nullptr;
  core::Motion<S> motion;
  motion.psi = seen.psi_rad;
  const auto controller_input = convert::controller_input_of<S>(own, {}, there, motion);
  const core::Vec2<S>& apart_n = controller_input.separation_n;
  const auto v_n =
      core::to_north_east(controller_input.psi_L, core::Vec2<S>{seen.u_mps, seen.v_mps});
  const double north_m = -convert::number(apart_n.x), east_m = -convert::number(apart_n.y);
  const convert::Position seen_at{own.north_m - apart_n.x, own.east_m - apart_n.y, own.origin};
  Vessel* vessel = find_at(id, seen_at, seen.stamp_us, now_us);
  if (vessel == nullptr) {
    const double comes_m =
        to_hull_m(nearest_m(north_m, east_m, convert::number(v_n.x), convert::number(v_n.y)),
                  reach_m.value_or(0));
    vessel = place_for(id, comes_m, own, now_us);
  }
  if (vessel == nullptr) return nullptr;
  if (reach_m) vessel->reach_m = *reach_m;
  const bool newest = date(*vessel, seen.stamp_us, now_us);
  const bool late = !newest || vessel->late_ms * std::int64_t{1000} > kForgotten_us;
  if (late && portable::hypot(north_m, east_m) < double{least_m_ + vessel->reach_m}) {
    late_near_us_ = now_us;
  }
  if (!newest) return nullptr;
  vessel->located = true;
  vessel->north_m = seen_at.north_m;
  vessel->east_m = seen_at.east_m;
  vessel->v_north_mps = static_cast<float>(convert::number(v_n.x));
  vessel->v_east_mps = static_cast<float>(convert::number(v_n.y));
  return vessel;
}

/// Dates a state; true if it is the newest, and young enough.
bool Neighbours::date(Vessel& vessel, std::int64_t stamp_us, std::int64_t now_us) {
  if (vessel.id <= kLastSystem) {
    const bool newest = date_by_stamp(vessel, stamp_us == 0 ? now_us : stamp_us, now_us);
    vessel.late_ms = milliseconds(now_us - vessel.true_us);
    return newest;
  }
  if (vessel.dated && stamp_us < vessel.true_us) return false;
  vessel.dated = true;
  vessel.true_us = stamp_us;
  return true;
}

/// A stamp earlier than the last one is from an overtaken message or, if the last state is over 3 s
/// old, perhaps from a restarted clock.
bool Neighbours::date_by_stamp(Vessel& vessel, std::int64_t stamp_us, std::int64_t now_us) {
  const std::int64_t last_us = vessel.true_us - vessel.ahead_us;
  const std::int64_t arrived_us = now_us - stamp_us, silent_us = now_us - vessel.true_us;
  const bool restarted = silent_us > kForgotten_us && (silent_us > kShipForgotten_us ||
                                                       is_restart(stamp_us, last_us, silent_us));
  std::int64_t ahead_us = arrived_us;
  if (vessel.dated && !restarted) {
    ahead_us = std::min(vessel.ahead_us + (stamp_us - last_us) / kDrift, arrived_us);
  }
  const std::int64_t late_us = arrived_us - ahead_us;
  if (late_us > kForgotten_us) {
    late_us_ = now_us;
    late_ = static_cast<std::uint8_t>(vessel.id);
  }
  const bool overtaken = vessel.dated && !restarted && stamp_us < last_us;
  if (overtaken || late_us > kShipForgotten_us) return false;
  vessel.dated = true;
  vessel.ahead_us = ahead_us;
  vessel.true_us = stamp_us + ahead_us;
  return true;
}

/// Moves the places to the frame of another origin.
template <class S>
void Neighbours::look_from(const convert::Position& own) {
  if (!convert::is_valid(own.origin)) return;
  for (Vessel& vessel : vessels_) {
    const convert::Position there{vessel.north_m, vessel.east_m, frame_};
    vessel.located = vessel.located && convert::near(own, there);
    if (!vessel.located) continue;
    const core::Vec2<S> apart_n = convert::separation<S>(own, there).n;
    vessel.north_m = own.north_m - apart_n.x;
    vessel.east_m = own.east_m - apart_n.y;
  }
  frame_ = own.origin;
}

Neighbours::Vessel* Neighbours::find(std::uint32_t id) {
  auto* const found = std::ranges::find_if(vessels_, [=](const Vessel& v) { return v.id == id; });
  return found == vessels_.end() ? nullptr : found;
}

/// The vessel's entry, or one with its id that counts as forgotten. If two vessels use one system
/// id, each has its own entry: a place too far from where a vessel's last state leads, forwards or
/// back in time, is another vessel's. The microcontroller's image has no room for this rule.
Neighbours::Vessel* Neighbours::find_at(std::uint32_t id, const convert::Position& place,
                                        std::int64_t stamp_us, std::int64_t now_us) {
  if (FLOTILLA_LOOKS_AHEAD == 0 || id > kLastSystem) return find(id);
  constexpr double kSlack_m = 10, kTurns = 0.5;  // of the way since then
  constexpr double kLongest_s = 30;
  Vessel *best = nullptr, *forgotten = nullptr;
  double least_off_m = 0;
  for (Vessel& v : vessels_) {
    if (v.id != id) continue;
    if (!counts(v, now_us)) {
      forgotten = &v;
      continue;
    }
    const std::int64_t last_us = v.true_us - v.ahead_us;
    const std::int64_t later_us = (stamp_us == 0 ? now_us - v.ahead_us : stamp_us) - last_us;
    const double s = std::clamp(1e-6 * static_cast<double>(later_us), -kLongest_s, kLongest_s);
    const double v_north_mps = double{v.v_north_mps}, v_east_mps = double{v.v_east_mps};
    const double off_m =
        portable::hypot(convert::number(place.north_m - v.north_m) - s * v_north_mps,
                        convert::number(place.east_m - v.east_m) - s * v_east_mps) -
        kTurns * std::abs(s) * portable::hypot(v_north_mps, v_east_mps);
    if (off_m > (best == nullptr ? kSlack_m : least_off_m)) continue;
    best = &v;
    least_off_m = off_m;
  }
  return best != nullptr ? best : forgotten;
}

double Neighbours::comes_m(const Vessel& v, const convert::Position& own) {
  if (!v.located) return std::numeric_limits<double>::max();
  return to_hull_m(
      nearest_m(convert::number(v.north_m - own.north_m), convert::number(v.east_m - own.east_m),
                double{v.v_north_mps}, double{v.v_east_mps}),
      v.reach_m);
}

/// A free entry, else that of the vessel that stays farthest away, if this one comes nearer.
Neighbours::Vessel* Neighbours::place_for(std::uint32_t id, double near_m,
                                          const convert::Position& own, std::int64_t now_us) {
  double farthest_m = near_m;
  Vessel* place = nullptr;
  for (Vessel& v : vessels_) {
    const bool free = v.id == 0 || now_us - v.true_us > patience_us(v);
    const double far_m = comes_m(v, own);
    if (!free && !(far_m > farthest_m)) continue;
    place = &v;
    if (free) break;
    farthest_m = far_m;
  }
  if (place == nullptr) return nullptr;
  used_ = std::max(used_, static_cast<std::size_t>(place - vessels_.data()) + 1);
  *place = {};
  place->id = id;
  place->true_us = now_us;
  return place;
}

std::int64_t Neighbours::patience_us(const Vessel& vessel) {
  if (vessel.rests) return kRestingForgotten_us;
  return vessel.id > kLastSystem ? kShipForgotten_us
                                 : kForgotten_us + std::int64_t{vessel.late_ms} * 1000;
}

bool Neighbours::counts(const Vessel& vessel, std::int64_t now_us) {
  const std::int64_t age_us = now_us - vessel.true_us;
  return vessel.located && age_us <= patience_us(vessel) &&
         (vessel.rests || age_us <= kShipForgotten_us);
}

bool Neighbours::has_way(const Vessel& vessel) const {
  if (vessel.id == leader_system_ || !vessel.steered || !vessel.depth) return true;
  return *vessel.depth == depth() ? vessel.id < own_system_ : *vessel.depth < depth();
}

std::uint8_t Neighbours::depth() const {
  return static_cast<std::uint8_t>(
      std::min<int>(leader_depth_.value_or(0) + 1, static_cast<int>(kDeepest)));
}

/// The vessel extrapolated to now; its right of way is not known here.
template <class S>
core::OtherVessel<S> Neighbours::seen(const Vessel& v, const convert::Position& own,
                                      const core::Vec2<S>& moved_n, std::int64_t now_us) {
  const std::int64_t told_us = now_us - v.true_us;
  const S age = convert::seconds<S>(v.rests ? std::min(told_us, kSways_us) : told_us) +
                convert::scalar<S>(kOnItsWay_s);
  const core::Vec2<S> v_n = {convert::scalar<S>(v.v_north_mps), convert::scalar<S>(v.v_east_mps)};
  return {{convert::scalar<S>(v.north_m - own.north_m) + age * v_n.x - moved_n.x,
           convert::scalar<S>(v.east_m - own.east_m) + age * v_n.y - moved_n.y},
          v_n,
          age * core::length(v_n) + convert::scalar<S>(v.reach_m)};  // it may have stopped since
}

bool Neighbours::any(std::int64_t now_us) const {
  return watches() &&
         std::ranges::any_of(tracked(), [&](const Vessel& v) { return counts(v, now_us); });
}

template <class S>
core::Traffic<S> Neighbours::traffic(const convert::Position& own, const core::Vec2<S>& moved_n,
                                     std::int64_t now_us) const {
  core::Traffic<S> out;
  if (!same(own.origin, frame_)) return out;
  const auto add = [&](const Vessel& v) {
    core::OtherVessel<S>& other = out.vessels[out.count++];
    other = seen(v, own, moved_n, now_us);
    other.has_way = has_way(v);
    other.stranger = !v.depth && v.id != leader_system_;
  };
  if (used_ <= core::kMaxVessels) {
    for (const Vessel& v : tracked()) {
      if (counts(v, now_us)) add(v);
    }
    return out;
  }
  std::array<const Vessel*, kKept> known{};
  std::size_t count = 0;
  for (const Vessel& v : tracked()) {
    if (counts(v, now_us)) known[count++] = &v;
  }
  const std::size_t most = std::min(count, core::kMaxVessels);
  std::ranges::nth_element(known.begin(), known.begin() + static_cast<std::ptrdiff_t>(most),
                           known.begin() + static_cast<std::ptrdiff_t>(count), {},
                           [&](const Vessel* v) { return comes_m(*v, own); });
  for (const Vessel* v : std::span(known).first(most)) add(*v);
  return out;
}

template <class S>
bool Neighbours::clear(const convert::Position& own, const core::Vec2<S>& moved_n,
                       std::int64_t now_us) const {
  if (!watches() || !same(own.origin, frame_)) return true;
  if (now_us - late_near_us_ < kForgotten_us) return false;
  return std::ranges::none_of(tracked(), [&](const Vessel& v) {
    return counts(v, now_us) && core::length(seen(v, own, moved_n, now_us).p_n) <
                                    convert::scalar<S>(least_m_ + v.reach_m);
  });
}

#define FLOTILLA_INSTANTIATE(S)                                                                 \
  template void Neighbours::look_from<S>(const convert::Position&);                             \
  template void Neighbours::take_news<S>(const link::Received&, const convert::Position&,       \
                                         std::int64_t, std::optional<float>);                   \
  template core::Traffic<S> Neighbours::traffic(const convert::Position&, const core::Vec2<S>&, \
                                                std::int64_t) const;                            \
  template bool Neighbours::clear(const convert::Position&, const core::Vec2<S>&, std::int64_t) \
      const;
FLOTILLA_INSTANTIATE(float)
FLOTILLA_INSTANTIATE(double)
FLOTILLA_INSTANTIATE(core::Q16)
#undef FLOTILLA_INSTANTIATE

}  // namespace flotilla::app
