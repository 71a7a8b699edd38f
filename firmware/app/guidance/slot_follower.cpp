// SPDX-License-Identifier: MIT
#include "app/guidance/slot_follower.hpp"

#include <utility>

namespace flotilla::app {
namespace {

template <class S>
bool same_slot(const Lead<S>& a, const Lead<S>& b) {
  const auto same = [](const core::Vec2<S>& p, const core::Vec2<S>& q) {
    return p.x == q.x && p.y == q.y;
  };
  return a.slot.turns == b.slot.turns && same(a.slot.d, b.slot.d) && same(a.offset_n, b.offset_n);
}

}  // namespace

template <class S>
core::ControllerInput<S> controller_input(const Lead<S>& lead, const OwnMotion<S>& own,
                                          const core::Vessel<S>& vessel) {
  auto in = convert::controller_input_of<S>(own.anchor(), own.motion(), lead.position, lead.motion);
  in.separation_n = {in.separation_n.x - lead.offset_n.x, in.separation_n.y - lead.offset_n.y};
  in.current_n = own.observer().c_n;
  in.unknown = core::unknown_wrench(vessel, own.observer());
  return in;
}

/// For a boat in its slot, the step of the slot's position at a change of lead fades out. A boat
/// that still closes up, or whose slot is now elsewhere, heads for the new slot at once. A new slot
/// behind the same lead, or one elsewhere, restarts the approach.
template <class S>
void SlotFollower<S>::follow(const convert::Law<S>& law, const OwnMotion<S>& own,
                             const Lead<S>& next, S dt) {
  if (lead_.leader != next.leader) start();
  if (!starting_ && lead_.branch == next.branch && !same_slot(lead_, next)) station_ = {};
  if (starting_) {
    shift_n_ = {};
    blend_ = {};
  } else if (lead_.branch != next.branch) {
    const auto in = controller_input(next, own, law.controller.vessel);
    const core::Vec2<S> d_n =
        next.slot.turns ? core::to_north_east(in.psi_L, next.slot.d) : next.slot.d;
    const core::Vec2<S> was = core::to_north_east(error_.R, core::Vec2<S>{error_.e.x, error_.e.y});
    const core::Vec2<S> step = {in.separation_n.x - d_n.x - shift_n_.x - was.x,
                                in.separation_n.y - d_n.y - shift_n_.y - was.y};
    // For example, because the leader is far from its own slot behind the root.
    const bool elsewhere = core::max(S(5), law.station.D) < core::hypot(step.x, step.y);
    if (elsewhere) core::station_moved(station_);
    blend_ = elsewhere || S(1) < off() ? core::Blend<S>{} : core::blend_start(step);
  }
  lead_ = next;
  coast_ = core::coast_start(next.motion);
  core::blend_forward(blend_, dt);
}

template <class S>
bool SlotFollower<S>::advance_shift_timer(S dt) {
  shift_s_ = shift_s_ + dt;
  return !(shift_s_ < S(0.2));
}

template <class S>
void SlotFollower<S>::shift(const core::Vec2<S>& e_L) {
  shift_n_ = core::shift_forward(core::ShiftParams<S>{}, shift_n_, e_L,
                                 core::min(std::exchange(shift_s_, S(0)), S(1)));
}

template <class S>
core::ControllerOutput<S> SlotFollower<S>::step(const convert::Law<S>& law, const OwnMotion<S>& own,
                                                const core::Traffic<S>* traffic, S dt) {
  core::ControllerInput<S> in = controller_input(lead_, own, law.controller.vessel);
  const core::Vec2<S> rest = core::rest_of(blend_);
  in.separation_n = {in.separation_n.x - rest.x - shift_n_.x,
                     in.separation_n.y - rest.y - shift_n_.y};
  if (starting_) state_ = core::controller_start(in);
  const S since = std::exchange(starting_, false) ? S(0) : dt;
  const auto out = core::controller_step(law.controller, state_, in, since, traffic);
  error_ = out.error;
  return out;
}

template <class S>
void SlotFollower<S>::coast(S coast_s, S dt) {
  core::coast_forward(coast_s, coast_, dt);
  lead_.motion = coast_.leader;
}

template <class S>
void SlotFollower<S>::judge(const convert::Law<S>& law, const core::ControllerOutput<S>& out,
                            const core::FormationError<S>& error, S r, S dt) {
  const bool at_rest = core::abs(out.slot.pace) < S(1.5) * law.controller.sight.epsilon;
  const bool turns = !at_rest && S(1) < core::abs(core::wrap_pi(error.e.psi));
  core::station_forward(law.station, station_,
                        {core::hypot(error.e.x, error.e.y), r, out.limits() != 0,
                         out.separation.yielding, at_rest, turns},
                        dt);
}

#define FLOTILLA_INSTANTIATE(S)                                                           \
  template class SlotFollower<S>;                                                         \
  template core::ControllerInput<S> controller_input(const Lead<S>&, const OwnMotion<S>&, \
                                                     const core::Vessel<S>&);
FLOTILLA_INSTANTIATE(float)
FLOTILLA_INSTANTIATE(double)
FLOTILLA_INSTANTIATE(core::Q16)
#undef FLOTILLA_INSTANTIATE

}  // namespace flotilla::app
