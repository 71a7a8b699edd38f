// SPDX-License-Identifier: MIT
// Environmental forces on the boats, added to w (R, N, 3) in their body axes. Equations, shapes and
// sources: sil/plant/weather.py, wind.py and waves.py.
#include <cmath>

#include "arrays.hpp"
#include "plant.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace flotilla::plant {
namespace {

void add_noise(Input<1> sigma, Input<3> normals, Array<3> w) {
  const std::size_t runs = w.shape(0), boats = w.shape(1);
  expect(sigma, "sigma: (R)", runs);
  expect(normals, "normals: (R, N, 3)", runs, boats, 3);
  expect(w, "w: (R, N, 3)", runs, boats, 3);
  const auto deviation = sigma.view();
  const auto random = normals.view();
  const auto out = w.view();
  for (std::size_t run = 0; run < runs; ++run) {
    for (std::size_t i = 0; i < boats; ++i) {
      for (std::size_t j = 0; j < 3; ++j) out(run, i, j) += deviation(run) * random(run, i, j);
    }
  }
}

void add_wind(Input<3> eta, Input<3> nu, Input<2> air, Input<3> boats, Array<3> w, double density) {
  const std::size_t runs = w.shape(0), count = w.shape(1);
  expect(eta, "eta: (R, N, 3)", runs, count, 3);
  expect(nu, "nu: (R, N, 3)", runs, count, 3);
  expect(air, "air: (R, 2)", runs, 2);
  expect(boats, "boats: (R, N, 6)", runs, count, 6);
  expect(w, "w: (R, N, 3)", runs, count, 3);
  const auto pose = eta.view(), velocity = nu.view(), windage = boats.view();
  const auto wind = air.view();
  const auto out = w.view();
  for (std::size_t run = 0; run < runs; ++run) {
    const double north = wind(run, 0), east = wind(run, 1);
    for (std::size_t i = 0; i < count; ++i) {
      const double frontal = windage(run, i, 0), lateral = windage(run, i, 1);
      const double c_x = windage(run, i, 2), c_y = windage(run, i, 3), c_n = windage(run, i, 4);
      const double length = windage(run, i, 5);
      const double cos = std::cos(pose(run, i, 2)), sin = std::sin(pose(run, i, 2));
      const double a_x = cos * north + sin * east - velocity(run, i, 0);
      const double a_y = cos * east - sin * north - velocity(run, i, 1);
      const double pressure = 0.5 * density * std::hypot(a_x, a_y);
      out(run, i, 0) += pressure * c_x * frontal * a_x;
      out(run, i, 1) += pressure * c_y * lateral * a_y;
      out(run, i, 2) += -density * c_n * lateral * length * a_x * a_y;
    }
  }
}

struct Means {
  double cos, x_sin;
};

/// Means over |x| ≤ `half` of cos(κ x) and x sin(κ x), a = κ `half`.
Means along(double a, double half) {
  if (std::abs(a) < 1e-3) return {1.0 - a * a / 6.0, half * a / 3.0};
  const double sinc = std::sin(a) / a;
  return {sinc, half * (sinc - std::cos(a)) / a};
}

void add_waves(double t_s, Input<3> eta, Input<3> waves, Input<1, std::int64_t> counts,
               Input<1> course_rad, Input<3> bodies, Array<3> w, double drift_Npm2) {
  const std::size_t runs = w.shape(0), boats = w.shape(1);
  expect(eta, "eta: (R, N, 3)", runs, boats, 3);
  expect(waves, "waves: (R, m, 4)", runs, waves.shape(1), 4);
  expect(counts, "counts: (R)", runs);
  expect(course_rad, "course_rad: (R)", runs);
  expect(bodies, "bodies: (R, N, 7)", runs, boats, 7);
  expect(w, "w: (R, N, 3)", runs, boats, 3);
  const auto pose = eta.view(), wave = waves.view(), body = bodies.view();
  const auto count = counts.view();
  const auto to = course_rad.view();
  const auto out = w.view();
  for (std::size_t run = 0; run < runs; ++run) {
    if (count(run) < 0 || static_cast<std::size_t>(count(run)) > waves.shape(1)) {
      throw nb::value_error("counts: at most m");
    }
    const auto components = static_cast<std::size_t>(count(run));
    const double course = to(run);
    for (std::size_t i = 0; components > 0 && i < boats; ++i) {
      const double m11 = body(run, i, 0), m22 = body(run, i, 1), length = body(run, i, 2);
      const double draft = body(run, i, 3), b = body(run, i, 4);
      const double way = pose(run, i, 0) * std::cos(course) + pose(run, i, 1) * std::sin(course);
      const double ahead = std::cos(course - pose(run, i, 2));
      const double abeam = std::sin(course - pose(run, i, 2));
      double surge = 0.0, sway = 0.0, yaw = 0.0, real = 0.0, imaginary = 0.0;
      for (std::size_t j = 0; j < components; ++j) {
        const double omega = wave(run, j, 0), k = wave(run, j, 1), amplitude = wave(run, j, 2);
        const double phi = omega * t_s - k * way + wave(run, j, 3);
        const double cos = std::cos(phi), sin = std::sin(phi);
        real += amplitude * cos;
        imaginary += amplitude * sin;
        const double acceleration = -omega * omega * amplitude * std::exp(-0.5 * k * draft);
        const auto [mean, lever] = along(0.5 * k * ahead * length, 0.5 * length);
        const double across = k * abeam * b;
        // Averages over both hulls of sin(φ − κ·r) and of its moments about the centre.
        surge += acceleration * mean * std::cos(across) * sin;
        yaw += acceleration * ahead * mean * m11 * b * std::sin(across) * cos;
        sway += acceleration * mean * std::cos(across) * sin;
        yaw -= acceleration * abeam * lever * m22 * std::cos(across) * cos;
      }
      const double drift = drift_Npm2 * (real * real + imaginary * imaginary);
      out(run, i, 0) += (m11 * surge + drift * body(run, i, 5)) * ahead;
      out(run, i, 1) += (m22 * sway + drift * body(run, i, 6)) * abeam;
      out(run, i, 2) += yaw;
    }
  }
}

}  // namespace

void bind_weather(nb::module_& m) {
  m.def("add_noise", &add_noise, "sigma"_a.noconvert(), "normals"_a.noconvert(), "w"_a.noconvert(),
        "Adds white noise to w: `sil.plant.weather.WhiteNoise`.");
  m.def("add_wind", &add_wind, "eta"_a.noconvert(), "nu"_a.noconvert(), "air"_a.noconvert(),
        "boats"_a.noconvert(), "w"_a.noconvert(), "density"_a,
        "Adds the wind's force to w: `sil.plant.wind.Wind`.");
  m.def("add_waves", &add_waves, "t_s"_a, "eta"_a.noconvert(), "waves"_a.noconvert(),
        "counts"_a.noconvert(), "course_rad"_a.noconvert(), "bodies"_a.noconvert(),
        "w"_a.noconvert(), "drift_Npm2"_a, "Adds the waves' force to w: `sil.plant.waves.Waves`.");
}

}  // namespace flotilla::plant
