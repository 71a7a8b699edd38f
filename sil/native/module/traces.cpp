// SPDX-License-Identifier: MIT
#include "traces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "plant/arrays.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using namespace flotilla::plant;

namespace {

/// Stores eta and nu (leaders first, then boats) at index `at` of their runs.
void note_truth(std::size_t at, const Input<2>& eta, const Input<2>& nu, const Array<4>& eta_out,
                const Array<4>& nu_out) {
  const std::size_t runs = eta_out.shape(0), agents = eta_out.shape(2);
  const auto pose = eta.view(), velocity = nu.view();
  const auto poses = eta_out.view(), velocities = nu_out.view();
  for (std::size_t run = 0; run < runs; ++run) {
    for (std::size_t i = 0; i < agents; ++i) {
      const std::size_t row = i == 0 ? run : runs + run * (agents - 1) + i - 1;
      for (std::size_t j = 0; j < 3; ++j) {
        poses(run, at, i, j) = pose(row, j);
        velocities(run, at, i, j) = velocity(row, j);
      }
    }
  }
}

void note_tick(std::size_t k, std::size_t every, Input<2> eta, Input<2> nu, Input<2> tau,
               Input<1, std::uint8_t> states, Array<4> eta_out, Array<4> nu_out, Array<4> tau_out,
               Array<2, std::int64_t> counts) {
  const std::size_t runs = tau_out.shape(0), kept = tau_out.shape(1), boats = tau_out.shape(2);
  const std::size_t agents = boats + 1, samples = eta_out.shape(1);
  expect(eta, "eta: (R + R N, 3)", runs * agents, 3);
  expect(nu, "nu: (R + R N, 3)", runs * agents, 3);
  expect(tau, "tau: (R N, 2)", runs * boats, 2);
  expect(states, "states: (R N)", runs * boats);
  expect(eta_out, "eta_out: (R, kept, N + 1, 3)", runs, samples, agents, 3);
  expect(nu_out, "nu_out: (R, kept, N + 1, 3)", runs, samples, agents, 3);
  expect(tau_out, "tau_out: (R, kept, N, 2)", runs, kept, boats, 2);
  expect(counts, "counts: (R N, states)", runs * boats, counts.shape(1));
  if (every == 0) throw nb::value_error("every: 1 or more");
  const auto state = states.view();
  const auto count = counts.view();
  for (std::size_t boat = 0; boat < runs * boats; ++boat) {
    const std::size_t now = state(boat);
    if (now >= counts.shape(1)) throw nb::value_error("states: beyond the columns of counts");
    ++count(boat, now);
  }
  if (k % every == 0 && k / every < kept) {
    const auto given = tau.view();
    const auto out = tau_out.view();
    for (std::size_t boat = 0; boat < runs * boats; ++boat) {
      for (std::size_t j = 0; j < 2; ++j) {
        out(boat / boats, k / every, boat % boats, j) = given(boat, j);
      }
    }
  }
  const std::size_t at = (k + 1) / every;
  if ((k + 1) % every == 0 && at < samples) note_truth(at, eta, nu, eta_out, nu_out);
}

void formation_errors(Input<3> eta, Input<1, std::int64_t> follows, Input<2> offset_m,
                      Input<1, bool> turns, Array<3> error) {
  const std::size_t ticks = eta.shape(0), boats = follows.shape(0);
  expect(eta, "eta: (T, N + 1, 3)", ticks, boats + 1, 3);
  expect(offset_m, "offset_m: (N, 2)", boats, 2);
  expect(turns, "turns: (N)", boats);
  expect(error, "error: (T, N, 3)", ticks, boats, 3);
  const auto pose = eta.view();
  const auto leader_of = follows.view();
  const auto slot = offset_m.view();
  const auto swings = turns.view();
  const auto out = error.view();
  for (std::size_t i = 0; i < boats; ++i) {
    if (leader_of(i) < 0 || static_cast<std::size_t>(leader_of(i)) > boats) {
      throw nb::value_error("follows: from 0 to N");
    }
  }
  for (std::size_t k = 0; k < ticks; ++k) {
    for (std::size_t i = 0; i < boats; ++i) {
      const auto leader = static_cast<std::size_t>(leader_of(i));
      double north = slot(i, 0), east = slot(i, 1);
      const double heading = pose(k, leader, 2), own = pose(k, i + 1, 2);
      if (swings(i)) {
        const double cos = std::cos(heading), sin = std::sin(heading);
        const double ahead = north, abeam = east;
        north = cos * ahead - sin * abeam;
        east = sin * ahead + cos * abeam;
      }
      const double x = pose(k, i + 1, 0) - (pose(k, leader, 0) + north);
      const double y = pose(k, i + 1, 1) - (pose(k, leader, 1) + east);
      const double cos = std::cos(own), sin = std::sin(own);
      out(k, i, 0) = cos * x + sin * y;
      out(k, i, 1) = cos * y - sin * x;
      out(k, i, 2) = own - heading;
    }
  }
}

/// Boats are kept sorted by x, an order that changes little from tick to tick, and compared only
/// while their distance along x is less than the smallest distance so far.
double least_square_distance(Input<3> eta) {
  struct Place {
    double x, y;
    std::size_t boat;
  };
  expect(eta, "eta: (T, N + 1, 3)", eta.shape(0), eta.shape(1), 3);
  const auto pose = eta.view();
  const std::size_t boats = std::max<std::size_t>(1, eta.shape(1)) - 1;
  std::vector<Place> places(boats);
  for (std::size_t i = 0; i < boats; ++i) places[i].boat = i + 1;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < eta.shape(0); ++k) {
    for (std::size_t i = 0; i < boats; ++i) {
      const std::size_t boat = places[i].boat;
      Place place{pose(k, boat, 0), pose(k, boat, 1), boat};
      // sort unknown positions (NaN) to the end
      if (std::isnan(place.x)) place.x = std::numeric_limits<double>::infinity();
      std::size_t at = i;
      for (; at > 0 && places[at - 1].x > place.x; --at) places[at] = places[at - 1];
      places[at] = place;
    }
    for (std::size_t i = 0; i < boats; ++i) {
      for (std::size_t j = i + 1; j < boats; ++j) {
        const double x = places[j].x - places[i].x, y = places[j].y - places[i].y;
        if (!(x * x < least)) break;
        least = std::min(least, x * x + y * y);
      }
    }
  }
  return least;
}

constexpr std::size_t kRecordHead = 12, kSigned = 13;
constexpr std::uint8_t kMavlink2 = 0xFD;

std::uint64_t little_endian(const std::uint8_t* data, std::size_t bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) value |= std::uint64_t{data[i]} << (8 * i);
  return value;
}

using Bytes = nb::ndarray<const std::uint8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Frame = std::array<std::int64_t, 4>;

/// Layout of a recording: `sil.lockstep.recording`.
nb::tuple radio_frames(Bytes records, int channel, Input<1, bool> wanted) {
  expect(wanted, "wanted: (65536)", 1 << 16);
  const auto is_wanted = wanted.view();
  const std::uint8_t* data = records.data();
  const std::size_t size = records.shape(0);
  auto* found = new std::vector<Frame>;
  const nb::capsule owner(found,
                          [](void* p) noexcept { delete static_cast<std::vector<Frame>*>(p); });
  std::uint64_t t_us = 0;
  for (std::size_t at = 0; at + kRecordHead <= size;) {
    t_us = little_endian(data + at, 8);
    const int where = data[at + 8], agent = data[at + 9];
    std::size_t begin = at + kRecordHead;
    const std::size_t end = std::min(begin + little_endian(data + at + 10, 2), size);
    at = end;
    if (where != channel || agent == 0) continue;
    while (begin + kRecordHead <= end && data[begin] == kMavlink2) {
      const std::size_t length =
          kRecordHead + data[begin + 1] + ((data[begin + 2] & 1U) != 0 ? kSigned : 0);
      if (is_wanted(little_endian(data + begin + 7, 2))) {
        found->push_back({static_cast<std::int64_t>(t_us), agent, static_cast<std::int64_t>(begin),
                          static_cast<std::int64_t>(std::min(begin + length, end))});
      }
      begin += length;
    }
  }
  using Table = nb::ndarray<nb::numpy, std::int64_t>;
  auto* values = found->empty() ? nullptr : found->front().data();
  return nb::make_tuple(Table(values, {found->size(), 4}, owner), t_us);
}

}  // namespace

void bind_traces(nb::module_& m) {
  m.def("note_tick", &note_tick, "k"_a, "every"_a, "eta"_a.noconvert(), "nu"_a.noconvert(),
        "tau"_a.noconvert(), "states"_a.noconvert(), "eta_out"_a.noconvert(),
        "nu_out"_a.noconvert(), "tau_out"_a.noconvert(), "counts"_a.noconvert(),
        "Stores tau and states of tick k, and eta and nu of the next one: "
        "`sil.lockstep.trace.Tracer`.");
  m.def("formation_errors", &formation_errors, "eta"_a.noconvert(), "follows"_a.noconvert(),
        "offset_m"_a.noconvert(), "turns"_a.noconvert(), "error"_a.noconvert(),
        "Writes error (T, N, 3), with e_ψ not wrapped: `sil.lockstep.metrics.formation_error`.");
  m.def("least_square_distance", &least_square_distance, "eta"_a.noconvert(),
        "Square of the smallest distance between two boats in eta (T, N + 1, 3), m².\n\n"
        "Infinite if no two positions are known. Agent 0, the leader, does not count.");
  m.def("radio_frames", &radio_frames, "records"_a.noconvert(), "channel"_a, "wanted"_a.noconvert(),
        "Finds messages sent by radio in a recording. Returns them and the last record's time.\n\n"
        "wanted (65536): whether to find each message number. Rows of the result (F, 4): time,\n"
        "agent, begin and end in the bytes. Times in us. Layout: `sil.lockstep.recording`.");
}
