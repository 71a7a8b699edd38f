// SPDX-License-Identifier: MIT
// Each extension can be switched off alone; the others work as if it did not exist.
#include "core/piloted_boat.hpp"

namespace flotilla::core {
namespace {

using testing::Random;
using testing::same_bits;

constexpr std::uint32_t kSeed = 95;

enum class Extension { kNone, kSteeredSlot, kLineOfSight, kLimits, kCurrent, kUnknown };

/// The slot of the paper, with the pace of the extended slot.
template <class S>
Slot<S> paper_slot(const ControllerParams<S>& params, SlotState<S>& state,
                   const ControllerInput<S>& in, S dt) {
  Slot<S> slot = slot_beside(in, params.slot.d);
  slot.pace = slot_forward(params.slot, params.vessel, state, in, dt).pace;
  return slot;
}

/// One step of the law from its parts, without one of them.
template <class S>
ControllerOutput<S> step_without(Extension piece, const ControllerParams<S>& params,
                                 ControllerState<S>& state, const ControllerInput<S>& in, S dt) {
  ControllerOutput<S> out;
  ControllerInput<S> seen = in;
  if (piece == Extension::kCurrent) seen.current_n = {};
  out.slot = piece == Extension::kSteeredSlot
                 ? paper_slot(params, state.slot, seen, dt)
                 : slot_forward(params.slot, params.vessel, state.slot, seen, dt);
  out.error = formation_error(seen, out.slot);
  const Vec2<S> c_b = to_body(seen.psi, seen.current_n);
  ControllerParams<S> limits = params;
  S& u_max = limits.outer.u_max;
  if (piece == Extension::kLimits) u_max = limits.outer.r_max = S(1e9);  // that nobody reaches
  Slot<S> sailed = out.slot;
  if (piece != Extension::kLineOfSight) {
    if (piece == Extension::kUnknown) seen.unknown = {};
    const ApproachParams<S> approach = approach_params(limits);
    push_forward(approach, params.vessel, state.approach, seen, out.slot, dt);
    const auto to_slot = course(limits, state.approach, seen, out.slot, out.error);
    sailed = to_slot.slot;
    out.sight = to_slot.sight;
  }
  virtual_sway_forward(params.vessel, state.outer, dt);
  out.desired = virtual_velocity(limits.outer, state.outer, sailed, out.error, out.sight);
  limit_growth(limits.outer, state.outer, dt, out.desired);
  VirtualVelocity<S> through_the_water = out.desired;
  Nu<S> nu = seen.nu;
  if (piece != Extension::kCurrent) {
    through_the_water = through_water(out.desired, c_b, seen.nu.r);
    nu = {nu.u - c_b.x, nu.v - c_b.y, nu.r};
  }
  state.outer.u_star_held = through_the_water.nu_star.u;
  state.outer.r_star_held = through_the_water.nu_star.r;
  out.tau = pd_plus(params.inner, params.vessel, through_the_water, nu);
  if (piece != Extension::kUnknown) out.tau = {out.tau.X - in.unknown.X, out.tau.N - in.unknown.N};
  out.allocation = allocate(params.propellers, out.tau);
  return out;
}

template <class S>
ControllerInput<S> wild_encounter(Random& random) {
  ControllerInput<S> in = testing::arbitrary_encounter<S>(random);
  in.current_n = {S(random(-0.5, 0.5)), S(random(-0.5, 0.5))};
  in.unknown = {S(random(-5, 5)), S(random(-2, 2))};
  return in;
}

template <class S>
void switch_off(Extension piece, ControllerParams<S>& params) {
  if (piece == Extension::kSteeredSlot) params.slot.steers = false;
  if (piece == Extension::kLineOfSight) params.sight.Delta = S(0);
  if (piece == Extension::kLimits) params.outer.u_max = params.outer.r_max = S(0);
}

template <class S>
void switch_off(Extension piece, ControllerInput<S>& in) {
  if (piece == Extension::kCurrent) in.current_n = {};
  if (piece == Extension::kUnknown) in.unknown = {};
}

template <class S>
bool same(const ControllerOutput<S>& a, const ControllerOutput<S>& b) {
  return same_bits(a.slot.psi, b.slot.psi) && same_bits(a.slot.nu.r, b.slot.nu.r) &&
         same_bits(a.error.e.y, b.error.e.y) && same_bits(a.sight.theta, b.sight.theta) &&
         same_bits(a.desired.nu_star.u, b.desired.nu_star.u) &&
         same_bits(a.desired.nu_star.v, b.desired.nu_star.v) &&
         same_bits(a.desired.nu_star.r, b.desired.nu_star.r) && same_bits(a.tau.X, b.tau.X) &&
         same_bits(a.tau.N, b.tau.N) &&
         same_bits(a.allocation.thrust.port, b.allocation.thrust.port) &&
         same_bits(a.allocation.thrust.stbd, b.allocation.thrust.stbd);
}

/// Number of steps that differ between the law with this extension at 0 and the law without it.
template <class S>
int differences(Extension off, Extension left_out) {
  Random random(kSeed);
  int out = 0;
  for (int run = 0; run < 500; ++run) {
    const auto full = testing::products_law<S>().law;
    ControllerParams<S> params = full;
    switch_off(off, params);
    ControllerState<S> state = controller_start(wild_encounter<S>(random)), other = state;
    for (int k = 0; k < 5; ++k) {
      const ControllerInput<S> in = wild_encounter<S>(random);
      ControllerInput<S> seen = in;
      switch_off(off, seen);
      const S dt = S(k == 0 ? 0 : 0.01);
      const auto with = controller_step(params, state, seen, dt);
      out += !same(with, step_without(left_out, full, other, in, dt));
    }
  }
  return out;
}

TEST_CASE_TEMPLATE("each extension at 0 has no effect at all", S, float, double) {
  INFO("seed ", kSeed);
  for (const Extension e : {Extension::kNone, Extension::kSteeredSlot, Extension::kLineOfSight,
                            Extension::kLimits, Extension::kCurrent, Extension::kUnknown}) {
    INFO("extension ", static_cast<int>(e));
    CHECK(differences<S>(e, e) == 0);
    if (e == Extension::kNone) continue;
    CHECK(differences<S>(Extension::kNone, e) > 1000);  // when on, the extension has an effect
  }
}

/// The estimates, at the end, of a boat that sails behind the S-curve in a current.
template <class S>
struct Assumed {
  ControllerOutput<S> out{};
  ControllerInput<S> in{};
};

template <class S>
Assumed<S> sail(const testing::ProductParams<S>& params) {
  const auto leader = testing::voyage(testing::s_curve, 0.01, 20);
  testing::PilotedBoat<S> boat;
  boat.hull = {{-3, 1, 0, 0, 0, 0}, {0.05, 0.1}};
  Assumed<S> last;
  for (const auto& seen : leader) last.out = boat.tick(params, seen, 0.01);
  last.in = boat.controller_input(params.law.vessel, leader.back());
  return last;
}

TEST_CASE_TEMPLATE("an extension at 0 contributes nothing, and the other extensions still work", S,
                   float, double) {
  auto params = testing::products_law<S>();
  const Assumed<S> all = sail(params);
  CHECK(all.in.unknown.X != S(0));
  CHECK(all.in.current_n.y != S(0));
  CHECK(all.out.sight.theta != S(0));

  params.observer.omega = S(0);  // LAW_OBS_BW
  Assumed<S> last = sail(params);
  CHECK(last.in.unknown.X == S(0));
  CHECK(last.in.unknown.N == S(0));
  CHECK(std::abs(last.in.current_n.y) > S(0.02));

  params = testing::products_law<S>();
  params.observer.omega_c = S(0);  // LAW_CUR_BW
  params.law.slot.steers = false;
  last = sail(params);
  CHECK(last.in.current_n.x == S(0));
  CHECK(last.in.current_n.y == S(0));
  CHECK(last.in.unknown.X != S(0));
  CHECK(last.out.slot.psi == last.in.psi_L);

  params = testing::products_law<S>();
  params.law.sight.Delta = S(0);  // LAW_XT_DIST
  last = sail(params);
  CHECK(last.out.sight.theta == S(0));
  CHECK(last.in.unknown.X != S(0));
}

}  // namespace
}  // namespace flotilla::core
