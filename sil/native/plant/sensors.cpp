// SPDX-License-Identifier: MIT
// Measurements of navigation units. Shapes: sil/plant/sensors.py.
#include "arrays.hpp"
#include "plant.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace flotilla::plant {
namespace {

void measure(Input<2> eta, Input<2> nu, Input<3> sigma, Input<1> worse, Input<4> normals,
             Array<2> eta_out, Array<2> nu_out) {
  const std::size_t runs = normals.shape(0), agents = normals.shape(2), rows = runs * agents;
  expect(eta, "eta: (R + R N, 3)", rows, 3);
  expect(nu, "nu: (R + R N, 3)", rows, 3);
  expect(sigma, "sigma: (R, 2, 3)", runs, 2, 3);
  expect(worse, "worse: (R + R N)", rows);
  expect(normals, "normals: (R, 2, N + 1, 3)", runs, 2, agents, 3);
  expect(eta_out, "eta_out: (R + R N, 3)", rows, 3);
  expect(nu_out, "nu_out: (R + R N, 3)", rows, 3);
  const auto s = sigma.view();
  const auto random = normals.view();
  const auto scale = worse.view();
  const auto pose = eta.view(), velocity = nu.view();
  const auto pose_out = eta_out.view(), velocity_out = nu_out.view();
  for (std::size_t run = 0; run < runs; ++run) {
    for (std::size_t agent = 0; agent < agents; ++agent) {
      const std::size_t row = agent == 0 ? run : runs + run * (agents - 1) + agent - 1;
      for (std::size_t j = 0; j < 3; ++j) {
        if (agent == 0) {
          pose_out(row, j) = pose(row, j);
          velocity_out(row, j) = velocity(row, j);
        } else {
          pose_out(row, j) = pose(row, j) + scale(row) * s(run, 0, j) * random(run, 0, agent, j);
          velocity_out(row, j) =
              velocity(row, j) + scale(row) * s(run, 1, j) * random(run, 1, agent, j);
        }
      }
    }
  }
}

}  // namespace

void bind_sensors(nb::module_& m) {
  m.def("measure", &measure, "eta"_a.noconvert(), "nu"_a.noconvert(), "sigma"_a.noconvert(),
        "worse"_a.noconvert(), "normals"_a.noconvert(), "eta_out"_a.noconvert(),
        "nu_out"_a.noconvert(),
        "Measures the boats' states with white noise, the leaders' without: "
        "`sil.plant.sensors.Sensors`.");
}

}  // namespace flotilla::plant
