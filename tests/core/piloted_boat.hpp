// SPDX-License-Identifier: MIT
// A boat under the product's law: its observer of motion and current, and the law.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "core/closed_loop.hpp"
#include "core/estimation/observer.hpp"

namespace flotilla::testing {

template <class S>
struct ProductParams {
  core::ControllerParams<S> law{};
  core::ObserverParams<S> observer{};
};

/// The defaults of app/parameters.def, with the paper's vessel and propellers of ±T_max.
template <class S>
ProductParams<S> products_law(double T_max = 20) {
  ProductParams<S> out;
  out.law = papers_controller<S>();
  out.law.slot.steers = true;
  out.law.outer = {S(0.2), S(0.5), S(1.5), S(0.8)};
  out.law.propellers = {S(0.25), in_scalar<S>(T_max), in_scalar<S>(T_max)};
  out.law.sight.Delta = S(1);
  out.observer.omega = S(2);
  out.observer.omega_c = S(0.1);
  const core::Vessel<S>& m = out.law.vessel;
  out.observer.b_max = {in_scalar<S>(T_max) / m.m11, in_scalar<S>(T_max) / m.m22,
                        in_scalar<S>(0.25 * T_max) / m.m33};
  return out;
}

template <class S>
struct PilotedBoat {
  Hull hull{};
  core::Observer<S> motion{};
  core::ControllerState<S> state{};
  core::Tau<S> given{};
  core::Tau<double> push{};     ///< a force unknown to the boat, such as wind
  core::Vec2<double> anchor{};  ///< the origin of motion.motion.moved_n
  bool under_way = false;
  int late = 0;  ///< age of a fix when it arrives, in ticks
  std::vector<Sighting> past{};

  core::ControllerInput<S> controller_input(const core::Vessel<S>& vessel,
                                            const Sighting& leader) const {
    const core::Motion<S>& m = motion.motion;
    core::ControllerInput<S> in;
    in.separation_n = {in_scalar<S>(anchor.x - leader.place.x) + m.moved_n.x,
                       in_scalar<S>(anchor.y - leader.place.y) + m.moved_n.y};
    in.psi = m.psi;
    in.psi_L = in_scalar<S>(leader.psi);
    in.nu = m.nu;
    in.nu_L = in_scalar<S>(leader.nu);
    in.nu_L_dot = in_scalar<S>(leader.nu_dot);
    in.current_n = motion.c_n;
    in.unknown = core::unknown_wrench(vessel, motion);
    return in;
  }

  /// The fix that arrives now, and its age, s.
  std::pair<Sighting, double> fix(double h) {
    past.push_back(sighting_of(hull));
    const std::size_t back = std::min(static_cast<std::size_t>(late), past.size() - 1);
    return {past[past.size() - 1 - back], h * static_cast<double>(back)};
  }

  /// One tick of h seconds: a fix, then the law, then the hull's motion under its thrust.
  core::ControllerOutput<S> tick(const ProductParams<S>& params, const Sighting& leader, double h) {
    const core::Vessel<S>& vessel = params.law.vessel;
    const auto [own, age] = fix(h);
    const S dt = under_way ? in_scalar<S>(h) : S(0);
    core::observer_forward(vessel, motion, given, dt);
    const core::Vec2<S>& moved = motion.motion.moved_n;
    core::observer_correct(params.observer, vessel, motion,
                           {{in_scalar<S>(anchor.x - own.place.x) + moved.x,
                             in_scalar<S>(anchor.y - own.place.y) + moved.y},
                            core::wrap_pi(in_scalar<S>(own.psi)),
                            in_scalar<S>(own.nu),
                            in_scalar<S>(age),
                            dt});
    anchor = own.place;
    const core::ControllerInput<S> in = controller_input(vessel, leader);
    if (!under_way) state = core::controller_start(in);
    under_way = true;
    const auto out = core::controller_step(params.law, state, in, dt);
    given = out.allocation.given;
    const core::Tau<double> tau = in_double(given);
    hull.advance({tau.X + push.X, tau.N + push.N}, h);
    return out;
  }
};

/// A leader's whole voyage, one sighting every h seconds.
inline std::vector<Sighting> voyage(const Thrusting& thrust, double h, double seconds) {
  std::vector<Sighting> out;
  Hull leader;
  for (double t = 0; t < seconds - h / 2; t += h) {
    const core::Tau<double> tau = thrust(t);
    out.push_back(sighting_of(leader, tau));
    leader.advance(tau, h);
  }
  return out;
}

}  // namespace flotilla::testing
