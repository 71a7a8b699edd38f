// SPDX-License-Identifier: MIT
// The model boat that logs are compared with. Equations and sources: sil/identify/voyage_model.py.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "arrays.hpp"
#include "plant.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace flotilla::plant {
namespace {

/// A column of `voyage_model.HULL_TERMS`.
struct Terms {
  double m22, m33, m23, d11, d11_quadratic, d22, d22_quadratic, d22_speed;
  double d33, d33_quadratic, d33_speed, munk, advance, lag, wind_x, wind_y, wind_n;
};
constexpr std::size_t kTerms = sizeof(Terms) / sizeof(double);

/// Current and wind over the water (north, east), moment of a gust.
struct Surroundings {
  double current_north, current_east, wind_north, wind_east, turn;
};

struct Forces {
  double port, stbd;
};

/// north, east, ψ, u, v, r
using State = std::array<double, 6>;

struct Size {
  double arm_m, length_m;
};

// Gauss-Legendre nodes along the hull (half lengths) and weights for the integral of cross-flow.
const std::array<double, 3> kPlaces = {-std::sqrt(0.6), 0.0, std::sqrt(0.6)};
constexpr std::array<double, 3> kWeights = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
// Limits, so that a wrong guess does not overflow: m, m, rad, m/s, m/s, rad/s.
constexpr State kGreatest = {1e4, 1e4, 1e3, 30.0, 30.0, 30.0};

State rates(const State& s, Forces thrust, const Terms& p, const Surroundings& w, Size size) {
  const auto [north, east, psi, u, v, r] = s;
  const double cos = std::cos(psi), sin = std::sin(psi), speed = std::abs(u);
  const double lost = 1.0 - p.advance * u;
  const double port = thrust.port * lost, stbd = thrust.stbd * lost;
  double side = 0.0, turn = 0.0;
  for (std::size_t k = 0; k < kPlaces.size(); ++k) {
    const double x = 0.5 * size.length_m * kPlaces[k];
    const double flow = v + x * r;
    const double drag = kWeights[k] * std::abs(flow) * flow;
    side += drag;
    turn += x * drag;
  }
  const double air_x = cos * w.wind_north + sin * w.wind_east - u;
  const double air_y = cos * w.wind_east - sin * w.wind_north - v;
  const double air = std::sqrt(air_x * air_x + air_y * air_y);
  const double surge = port + stbd + (p.m22 * v + p.m23 * r) * r + p.wind_x * air * air_x -
                       (p.d11 + p.d11_quadratic * speed) * u;
  const double sway =
      -u * r - (p.d22 + p.d22_speed * speed) * v - p.d22_quadratic * side + p.wind_y * air * air_y;
  const double yaw = w.turn - p.wind_n * air_x * air_y + size.arm_m * (port - stbd) -
                     (p.m22 - 1.0 + p.munk) * u * v - p.d22_quadratic * turn -
                     (p.d33 + p.d33_quadratic * std::abs(r) + p.d33_speed * speed + p.m23 * u) * r;
  const double det = p.m22 * p.m33 - p.m23 * p.m23;
  return {cos * u - sin * v + w.current_north, sin * u + cos * v + w.current_east, r, surge,
          (p.m33 * sway - p.m23 * yaw) / det,  (p.m22 * yaw - p.m23 * sway) / det};
}

State after(const State& s, const State& slope, double h) {
  State next;
  for (std::size_t j = 0; j < s.size(); ++j) next[j] = s[j] + h * slope[j];
  return next;
}

struct Boat {
  Terms terms;
  Surroundings around;
  State state;
  Forces force;
  double half, whole;  ///< share of the way to a held command in half a step, in a whole one

  Forces nearer(double share, Forces to) const {
    return {force.port + share * (to.port - force.port),
            force.stbd + share * (to.stbd - force.stbd)};
  }

  /// One step of classical Runge-Kutta 4; thrust at its start, middle and end.
  void carry(const std::array<Forces, 3>& thrust, Size size, double h) {
    const State& s = state;
    const State a = rates(s, thrust[0], terms, around, size);
    const State b = rates(after(s, a, 0.5 * h), thrust[1], terms, around, size);
    const State c = rates(after(s, b, 0.5 * h), thrust[1], terms, around, size);
    const State d = rates(after(s, c, h), thrust[2], terms, around, size);
    for (std::size_t j = 0; j < s.size(); ++j) {
      const double next = s[j] + h / 6.0 * (a[j] + 2.0 * (b[j] + c[j]) + d[j]);
      state[j] = std::clamp(next, -kGreatest[j], kGreatest[j]);
    }
  }
};

/// Middle of a step: −1 where the stretch begins, 1 where it ends.
double place_of(std::size_t step, std::size_t steps) {
  return 2.0 * (static_cast<double>(step) + 0.5) / static_cast<double>(steps) - 1.0;
}

void sail_voyages(Array<4> states, Input<4> thrust, Input<2> terms, Input<3> surroundings,
                  std::size_t before, std::size_t every, double h_s, double arm_m,
                  double length_m) {
  const std::size_t samples = states.shape(0), w = states.shape(2), c = states.shape(3);
  expect(states, "states: (samples, 6, W, C)", samples, 6, w, c);
  expect(thrust, "thrust: (before + every samples, 2, W, C)", before + every * samples, 2, w, c);
  expect(terms, "terms: (17, C)", kTerms, c);
  expect(surroundings, "surroundings: (8, W, C)", 8, w, c);
  const auto out = states.view();
  const auto wanted = thrust.view();
  const auto term = terms.view();
  const auto around = surroundings.view();
  std::vector<Boat> boats(c);  // of one stretch: the arrays' last axis
  for (std::size_t i = 0; i < w; ++i) {
    for (std::size_t j = 0; j < c; ++j) {
      Boat& boat = boats[j];
      boat.terms = {term(0, j),  term(1, j),  term(2, j),  term(3, j),  term(4, j),  term(5, j),
                    term(6, j),  term(7, j),  term(8, j),  term(9, j),  term(10, j), term(11, j),
                    term(12, j), term(13, j), term(14, j), term(15, j), term(16, j)};
      boat.around = {around(0, i, j), around(1, i, j), around(2, i, j), around(3, i, j),
                     around(4, i, j)};
      boat.half = 1.0 - std::exp(-0.5 * h_s / boat.terms.lag);
      boat.whole = 1.0 - std::exp(-h_s / boat.terms.lag);
      for (std::size_t n = 0; n < boat.state.size(); ++n) boat.state[n] = out(0, n, i, j);
      boat.force = {wanted(0, 0, i, j), wanted(0, 1, i, j)};
    }
    for (std::size_t k = 0; k < before + every * samples; ++k) {
      for (std::size_t j = 0; j < c; ++j) {
        Boat& boat = boats[j];
        const Forces to{wanted(k, 0, i, j), wanted(k, 1, i, j)};
        const Forces end = boat.nearer(boat.whole, to);
        if (k >= before) {
          if ((k - before) % every == 0) {
            const std::size_t sample = (k - before) / every;
            for (std::size_t n = 0; n < boat.state.size(); ++n)
              out(sample, n, i, j) = boat.state[n];
          }
          const double place = place_of(k - before, every * samples);
          boat.around.wind_north = around(2, i, j) + place * around(5, i, j);
          boat.around.wind_east = around(3, i, j) + place * around(6, i, j);
          boat.around.turn = around(4, i, j) + place * around(7, i, j);
          boat.carry({boat.force, boat.nearer(boat.half, to), end}, {arm_m, length_m}, h_s);
        }
        boat.force = end;
      }
    }
  }
}

}  // namespace

void bind_voyage(nb::module_& m) {
  m.def("sail_voyages", &sail_voyages, "states"_a.noconvert(), "thrust"_a.noconvert(),
        "terms"_a.noconvert(), "surroundings"_a.noconvert(), "before"_a, "every"_a, "h_s"_a,
        "arm_m"_a, "length_m"_a,
        "Sails from states[0], in place, by steps of `h_s` seconds. The first `before` steps only "
        "build up thrust: `sil.identify.voyage_model.simulate`.");
}

}  // namespace flotilla::plant
