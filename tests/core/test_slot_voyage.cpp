// SPDX-License-Identifier: MIT
// The slot of a leader under way: its motion compared with the differences of its places.
#include <vector>

#include "core/closed_loop.hpp"
#include "core/slot.hpp"

namespace flotilla::core {
namespace {

using testing::Hull;
using testing::Sighting;

constexpr double kH = 0.01;
const std::array<Vec2<double>, 5> kSlots = {{{0, 0}, {-1.5, -1.5}, {-1.5, 1}, {1, 1}, {-2, 0}}};

/// A slot and the place where it is.
struct Point {
  Slot<double> slot{};
  Vec2<double> place{};
  double psi_L = 0, v_w = 0;
};

struct Voyage {
  testing::Thrusting thrust = testing::s_curve;
  Vec2<double> current{};
  bool drifts = true;  ///< the leader; else it goes as if in still water
  double seconds = 100, h = kH;
};

SlotParams<double> steered(const Vec2<double>& d, bool turns) {
  SlotParams<double> params;
  params.d = d;
  params.turns = turns;
  params.steers = true;
  return params;
}

std::vector<Point> sail(const SlotParams<double>& params, const Voyage& voyage) {
  Hull leader{{3, -2, 0.4, 0.5, 0, 0}, voyage.drifts ? voyage.current : Vec2<double>{}};
  SlotState<double> state;
  std::vector<Point> out;
  for (double t = 0; t < voyage.seconds; t += voyage.h) {
    const Sighting seen = testing::sighting_of(leader, voyage.thrust(t));
    auto in = testing::controller_input_of<double>({}, seen);
    in.current_n = voyage.current;
    if (out.empty()) state = slot_start(in);
    const double h = out.empty() ? 0 : voyage.h;
    const auto slot = slot_forward(params, testing::papers_vessel<double>(), state, in, h);
    out.push_back(
        {slot, {seen.place.x + slot.d_n.x, seen.place.y + slot.d_n.y}, seen.psi, state.v_w});
    leader.advance(voyage.thrust(t), voyage.h);
  }
  return out;
}

Vec2<double> over_ground(const Slot<double>& slot) {
  return to_north_east(slot.psi, Vec2<double>{slot.nu.u, slot.nu.v});
}

Vec2<double> slope(const Vec2<double>& before, const Vec2<double>& after) {
  return {(after.x - before.x) / (2 * kH), (after.y - before.y) / (2 * kH)};
}

TEST_CASE(
    "a turning slot's velocity is the slope of its places, its acceleration that of its velocity") {
  for (const Vec2<double>& d : kSlots) {
    for (const Vec2<double>& current : {Vec2<double>{}, Vec2<double>{0.1, -0.05}}) {
      const auto path = sail(steered(d, true), {.current = current});
      for (std::size_t k = 1; k + 1 < path.size(); ++k) {
        const Slot<double>& now = path[k].slot;
        const Vec2<double> v = over_ground(now);
        const Vec2<double> moved = slope(path[k - 1].place, path[k + 1].place);
        REQUIRE(std::hypot(moved.x - v.x, moved.y - v.y) < 1e-4);
        const Vec2<double> a =
            to_body(now.psi, slope(over_ground(path[k - 1].slot), over_ground(path[k + 1].slot)));
        REQUIRE(std::abs(now.nu_dot.u - now.nu.r * now.nu.v - a.x) < 0.01);
        REQUIRE(std::abs(now.nu_dot.v + now.nu.r * now.nu.u - a.y) < 0.01);
      }
    }
  }
}

/// Sway of a boat that turns with r and has u through the water, from the start of the path on.
double worst_sway_error(const std::vector<Point>& path, const Vec2<double>& current) {
  double v = 0, worst = 0;
  for (std::size_t k = 0; k < path.size(); ++k) {
    const Slot<double>& now = path[k].slot;
    const Vec2<double> c = to_body(now.psi, current);
    Hull boat{{0, 0, 0, now.nu.u - c.x, v, now.nu.r}};
    if (static_cast<double>(k) * kH > 10) worst = std::max(worst, std::abs(now.nu.v - c.y - v));
    v += kH * Hull::rates(boat.q, {})[4];
  }
  return worst;
}

TEST_CASE("a boat that sails the slot's course has the slot's sway through the water by itself") {
  // Where a slot turns about its leader its sway is a few hundredths of a metre a second.
  for (const Vec2<double>& d : {kSlots[0], kSlots[2], kSlots[3], kSlots[4]}) {
    CHECK(worst_sway_error(sail(steered(d, true), {}), {}) < 0.02);
    const Vec2<double> c{0, 0.1};
    CHECK(worst_sway_error(sail(steered(d, false), {.current = c, .drifts = false}), c) < 0.005);
  }
  const Vec2<double> c{0, 0.3};
  CHECK(worst_sway_error(sail(steered({}, false), {.current = c, .drifts = false}), c) < 0.01);
}

TEST_CASE("behind a leader with the boat's own hull, in still water, slot and leader head alike") {
  const auto path = sail(steered({-2, -2}, false), {});
  for (std::size_t k = 300; k < path.size(); ++k) {
    REQUIRE(std::abs(path[k].slot.psi - path[k].psi_L) < 1e-3);
  }
}

TEST_CASE("the slot's yaw rate is the slope of its heading") {
  for (const Vec2<double>& d : kSlots) {
    for (const bool turns : {true, false}) {
      const auto path = sail(steered(d, turns), {.current = {0.05, 0.05}});
      double worst = 0, worst_slow = 0, fastest = 0;
      for (std::size_t k = 1000; k + 1 < path.size(); ++k) {
        const double turned = wrap_pi(path[k + 1].slot.psi - path[k - 1].slot.psi);
        double& most = path[k].slot.pace < 0.2 ? worst_slow : worst;
        most = std::max(most, std::abs(turned / (2 * kH) - path[k].slot.nu.r));
        fastest = std::max(fastest, std::abs(path[k].slot.nu.r));
      }
      CHECK(fastest > 0.3);
      // The smoothed rates lag behind, which matters more the slower the slot is.
      CHECK(worst < (turns ? 0.13 : 1e-3));
      CHECK(worst_slow < 0.6);
    }
  }
}

/// Largest step of the slot's heading from one tick to the next.
double largest_step(const std::vector<Point>& path) {
  double out = 0;
  for (std::size_t k = 1; k < path.size(); ++k) {
    out = std::max(out, std::abs(wrap_pi(path[k].slot.psi - path[k - 1].slot.psi)));
  }
  return out;
}

TEST_CASE(
    "a leader that stops, goes astern or turns on the spot never makes the slot's heading jump") {
  const std::array<testing::Thrusting, 3> manoeuvres = {
      [](double t) { return 20 < t && t < 60 ? Tau<double>{} : Tau<double>{2, 0.15}; },
      [](double t) { return Tau<double>{2.5 * std::cos(0.1 * t), 0.15 * std::sin(0.17 * t)}; },
      [](double t) { return t < 20 ? Tau<double>{2, 0} : Tau<double>{0, t < 25 ? 0 : 0.4}; }};
  for (const auto& thrust : manoeuvres) {
    for (const Vec2<double>& d : kSlots) {
      const Voyage coarse{.thrust = thrust, .current = {0.05, 0}, .drifts = false};
      Voyage fine = coarse;
      fine.h = kH / 8;
      const double step = largest_step(sail(steered(d, true), coarse));
      CHECK(step < 0.15);
      // With finer steps a jump would not become smaller.
      CHECK(largest_step(sail(steered(d, true), fine)) < 0.3 * step);
    }
  }
}

}  // namespace
}  // namespace flotilla::core
