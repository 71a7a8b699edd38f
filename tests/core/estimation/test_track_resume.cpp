// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "core/estimation/track.hpp"

namespace flotilla::core {
namespace {

TEST_CASE_TEMPLATE("an unknown vessel starts at the position from its other source", S, float,
                   double) {
  TrackState<S> state;
  track_resume(TrackParams<S>{}, state, {S(1), {S(2), S(0), S(0.5)}, S(0.1)});
  CHECK(state.started);
  CHECK(state.psi == S(1));
  CHECK(state.nu.u == S(2));
  CHECK(state.nu_dot.u == S(0));
  CHECK(state.dt == S(0));
  CHECK(state.a == TrackParams<S>{}.a_min);
}

}  // namespace
}  // namespace flotilla::core
