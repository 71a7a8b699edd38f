// SPDX-License-Identifier: MIT
// Late fixes: prediction by the wrenches given since, and the loop that is closed with them.
#include "core/piloted_boat.hpp"

namespace flotilla::core {
namespace {

using testing::Hull;
using testing::PilotedBoat;

/// A wrench that changes quickly compared with any age.
Tau<double> restless(double t) { return {4 + 4 * std::sin(9 * t), 0.8 * std::cos(7 * t)}; }

/// Error of the estimate after a fix of this age: m, m, rad, m/s, m/s, rad/s.
template <class S>
std::array<double, 6> mistake(double h, double age, double seconds, const testing::Thrusting& said,
                              const testing::Thrusting& done) {
  const Vessel<S> vessel = testing::papers_vessel<S>();
  Hull hull{{0, 0, 0.4, 0.5, 0, 0.1}}, then = hull;
  Observer<S> state;
  state.motion.nu = {S(7), S(7), S(7)};  // of no use
  const int ticks = static_cast<int>(std::lround(seconds / h));
  const int late = static_cast<int>(std::lround(age / h));
  for (int k = 0; k < ticks; ++k) {
    if (k == ticks - late) then = hull;
    const Tau<double> told = said(k * h);
    hull.advance(done(k * h), h);
    observer_forward(vessel, state, Tau<S>{S(told.X), S(told.N)}, S(h));
  }
  const Nu<S> nu{S(then.q[3]), S(then.q[4]), S(then.q[5])};
  observer_correct({}, vessel, state, Fix<S>{{}, S(then.q[2]), nu, S(late * h), S(0)});
  const Motion<S>& m = state.motion;
  return {double(m.moved_n.x) + then.q[0] - hull.q[0],
          double(m.moved_n.y) + then.q[1] - hull.q[1],
          double(m.psi) - hull.q[2],
          double(m.nu.u) - hull.q[3],
          double(m.nu.v) - hull.q[4],
          double(m.nu.r) - hull.q[5]};
}

double largest(const std::array<double, 6>& off) {
  double out = 0;
  for (const double x : off) out = std::max(out, std::abs(x));
  return out;
}

TEST_CASE_TEMPLATE("a late fix and the wrenches given since then yield the boat's present motion",
                   S, float, double) {
  for (const double h : {0.02, 0.01, 0.001}) {
    for (const double age : {0.04, 0.1, 0.2, 0.3, 0.5}) {
      INFO("tick ", h, " s, age ", age, " s");
      const double off = largest(mistake<S>(h, age, 2.03, restless, restless));
      CAPTURE(off);
      CHECK(off < 0.03);
      // A prediction as if the last wrench had been given all the time is worse.
      const auto last = [](double) { return restless(2.03); };
      const double naive = largest(mistake<S>(h, age, 2.03, last, restless));
      CAPTURE(naive);
      if (age > 0.15) CHECK(off < 0.3 * naive);
    }
  }
}

TEST_CASE_TEMPLATE("the boat remembers half a second at any rate of ticks", S, float, double) {
  for (const double h : {0.02, 0.01, 0.001}) {
    INFO("tick ", h, " s");
    Observer<S> state;
    for (double t = 0; t < 5; t += h)
      observer_forward(testing::papers_vessel<S>(), state, Tau<S>{S(1), S(2)}, S(h));
    double remembered = 0;
    for (int k = 0; k < WrenchHistory<S>::kLength; ++k) {
      remembered += double(state.given.time[k]);
      CHECK(state.given.tau[k].X == testing::approx(S(1)));
      CHECK(state.given.tau[k].N == testing::approx(S(2)));
    }
    CHECK(remembered > 0.5);
    CHECK(remembered < 1.3);
  }
}

TEST_CASE_TEMPLATE("before its memory begins, the boat is assumed to have given the oldest wrench",
                   S, float, double) {
  const auto steady = [](double) { return Tau<double>{3, 0.4}; };
  const auto before_too = [](double t) {
    return t < 1.5 ? Tau<double>{-9, 3} : Tau<double>{3, 0.4};
  };
  for (const double h : {0.02, 0.01, 0.001}) {
    INFO("tick ", h, " s");
    CHECK(largest(mistake<S>(h, 1.5, 3, steady, steady)) < 0.05);
    CHECK(largest(mistake<S>(h, 1.5, 3, before_too, before_too)) < 0.05);
    CHECK(largest(mistake<S>(h, 1.7, 3, before_too, before_too)) > 0.05);  // 0.2 s of the other
  }
}

TEST_CASE_TEMPLATE("before its first wrench a boat is assumed to have given none", S, float,
                   double) {
  const auto begins = [](double t) { return t < 0.2 ? Tau<double>{} : Tau<double>{5, 1}; };
  const Vessel<S> vessel = testing::papers_vessel<S>();
  for (const double h : {0.02, 0.01, 0.001}) {
    INFO("tick ", h, " s");
    Hull hull{{0, 0, 0.4, 0.5, 0, 0.1}};
    const Hull then = hull;
    Observer<S> state;
    for (int k = 0; k * h < 0.3 - h / 2; ++k) {
      hull.advance(begins(k * h + h / 2), h);
      if (k * h > 0.2 - h / 2) observer_forward(vessel, state, Tau<S>{S(5), S(1)}, S(h));
    }
    observer_correct({}, vessel, state, Fix<S>{{}, S(0.4), {S(0.5), S(0), S(0.1)}, S(0.3), S(0)});
    CHECK(std::abs(double(state.motion.moved_n.x) + then.q[0] - hull.q[0]) < 0.01);
    CHECK(std::abs(double(state.motion.nu.u) - hull.q[3]) < 0.03);
    CHECK(std::abs(double(state.motion.nu.r) - hull.q[5]) < 0.03);
  }
}

TEST_CASE_TEMPLATE(
    "with the paper's gains, fixes up to 0.3 s late move a boat's last place by less than 0.3 m", S,
    float, double) {
  testing::ProductParams<S> params;  // LAW_OBS_BW 0, LAW_CUR_BW 0
  params.law = testing::papers_controller<S>();
  const auto leader = testing::voyage(testing::s_curve, 0.01, 60);
  const auto sail = [&](int late) {
    PilotedBoat<S> boat;
    boat.hull.q = {1.46, 0.45, 1.33, 0, 0, 0};
    boat.late = late;
    for (const auto& seen : leader) boat.tick(params, seen, 0.01);
    return boat.hull;
  };
  const Hull punctual = sail(0);
  for (const int late : {4, 10, 20, 30}) {
    INFO("fixes ", late, " ticks late");
    const Hull hull = sail(late);
    const double off = std::hypot(hull.q[0] - punctual.q[0], hull.q[1] - punctual.q[1]);
    CAPTURE(off);
    CHECK(off < 0.3);
    CHECK(std::abs(wrap_pi(hull.q[2] - punctual.q[2])) < 0.3);
    CHECK(std::abs(hull.q[5]) < 1);
  }
}

TEST_CASE_TEMPLATE("LAW_OBS_BW or LAW_CUR_BW set to 0 under way: the estimate is dropped", S, float,
                   double) {
  const auto leader = testing::voyage(testing::s_curve, 0.01, 32);
  for (const bool forces : {true, false}) {
    auto params = testing::products_law<S>();
    PilotedBoat<S> boat;
    boat.hull = {{-3, 1, 0, 0, 0, 0}, {0.05, 0.2}};
    for (std::size_t k = 0; k < 3000; ++k) boat.tick(params, leader[k], 0.01);
    CHECK(boat.motion.b.u != S(0));
    CHECK(boat.motion.c_n.y != S(0));
    (forces ? params.observer.omega : params.observer.omega_c) = S(0);
    for (std::size_t k = 3000; k < 3002; ++k) {  // with the next fix already
      boat.tick(params, leader[k], 0.01);
      CHECK((boat.motion.b.u == S(0)) == forces);
      CHECK((boat.motion.b.r == S(0)) == forces);
      CHECK((boat.motion.c_n.x == S(0)) == !forces);
      CHECK((boat.motion.c_n.y == S(0)) == !forces);
    }
    params.observer.omega = params.observer.omega_c = S(0);
    boat.tick(params, leader[3002], 0.01);
    CHECK(boat.motion.b.v == S(0));
    CHECK(boat.motion.b.u == S(0));
    CHECK(boat.motion.c_n.x == S(0));
  }
}

}  // namespace
}  // namespace flotilla::core
