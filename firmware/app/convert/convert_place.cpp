// SPDX-License-Identifier: MIT
#include "app/convert/convert_place.hpp"

#include <variant>

namespace flotilla::app::convert {
namespace {

// Keeps the position and clears the rest of the motion: some senders fill in nothing else.
link::Odometry place_alone(link::Odometry m) {
  m.q = {1, 0, 0, 0};
  m.z = m.vx = m.vy = m.vz = m.rollspeed = m.pitchspeed = m.yawspeed = 0;
  m.child_frame_id = link::mav::kFrameLocalNed;
  return m;
}
link::LocalPositionNed place_alone(link::LocalPositionNed m) {
  m.z = m.vx = m.vy = m.vz = 0;
  return m;
}
link::GlobalPositionInt place_alone(link::GlobalPositionInt m) {
  m.vx = m.vy = 0;
  return m;
}
link::FollowTarget place_alone(link::FollowTarget m) {
  m.est_capabilities &= link::mav::kFollowPosition;
  if (m.est_capabilities != 0) m.est_capabilities |= link::mav::kFollowVelocity;
  m.vel = {};
  return m;
}

template <class S>
std::optional<Sample<S>> told_by(const link::Odometry& m) {
  return sample_of<S>(m).sample;
}
template <class S>
std::optional<Sample<S>> told_by(const auto& m) {
  return sample_of(m, HeadingSample<S>{});
}

}  // namespace

template <class S>
std::optional<Sample<S>> place_of(const link::Message& message) {
  const auto place = [](const auto* m) {
    const auto whole = told_by<S>(*m);
    return whole ? whole : told_by<S>(place_alone(*m));
  };
  if (const auto* m = std::get_if<link::Odometry>(&message)) return place(m);
  if (const auto* m = std::get_if<link::LocalPositionNed>(&message)) return place(m);
  if (const auto* m = std::get_if<link::GlobalPositionInt>(&message)) return place(m);
  const auto* m = std::get_if<link::FollowTarget>(&message);
  return m != nullptr ? place(m) : std::nullopt;
}

#define FLOTILLA_INSTANTIATE(S) template std::optional<Sample<S>> place_of<S>(const link::Message&);
FLOTILLA_INSTANTIATE(float)
FLOTILLA_INSTANTIATE(double)
FLOTILLA_INSTANTIATE(core::Q16)
#undef FLOTILLA_INSTANTIATE

}  // namespace flotilla::app::convert
