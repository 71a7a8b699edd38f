// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "app/convert/convert_scalar.hpp"
#include "app/plan/voyage.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;
using Kind = VoyageNews::Kind;

constexpr double kTick_s = 0.01;

PlanItem voyage_item(float share = 0, float radius_m = 0) {
  PlanItem item{.param = {share, radius_m, 0, 0}, .x = 410'000'000, .y = 20'000'000};
  item.command = mav::kVoyage;
  return item;
}

PlanItem waypoint(std::int32_t x) {
  PlanItem item{.x = x, .y = 20'000'000};
  item.command = mav::kNavWaypoint;
  return item;
}

VoyageRoom room(float radius_m = 60) {
  return {.id = {7, 1}, .radius_m = radius_m, .share = 0.8F, .rest_s = 3};
}

/// A hull of 24 kg in the room's axes, seen without noise. It knows none of the voyage's numbers.
template <class S>
struct Sea {
  HullVoyage<S> voyage;
  double north_m = 0, east_m = 0, psi = 0, u = 0, r = 0;
  double thrust_N = 20, drift_mps = 0;  // eastward
  bool waits = false, blocked = false;
  core::Thrust<S> shares{};
  std::vector<VoyageNews> news;
  double farthest_m = 0, fastest_mps = 0, t_s = 0;

  explicit Sea(const VoyageRoom& of = room()) { begin(of); }

  void begin(const VoyageRoom& of) {
    voyage.begin(of);
    voyage.limit({.mps = 1.8F, .radps = 1.6F});
  }

  void step() {
    const auto s = [](double x) { return convert::scalar<S>(x); };
    const double vn = u * std::cos(psi), ve = u * std::sin(psi) + drift_mps;
    shares = voyage.forward({{s(north_m), s(east_m)}, {s(vn), s(ve)}, s(psi), s(r), waits, blocked},
                            s(kTick_s));
    const double port = thrust_N * convert::number(shares.port),
                 stbd = thrust_N * convert::number(shares.stbd);
    u += kTick_s * (port + stbd - 9 * u - 8 * u * std::abs(u)) / 24;
    r += kTick_s * (0.29 * (port - stbd) - 9 * r) / 5.5;
    psi = std::remainder(psi + kTick_s * r, 2 * M_PI);
    north_m += kTick_s * vn;
    east_m += kTick_s * ve;
    t_s += kTick_s;
    farthest_m = std::max(farthest_m, std::hypot(north_m, east_m));
    fastest_mps = std::max(fastest_mps, std::abs(u));
    if (const auto told = voyage.take_news()) news.push_back(*told);
  }

  void sail(double seconds) {
    for (int n = static_cast<int>(seconds / kTick_s); n > 0 && voyage.is_on(); --n) step();
  }

  /// Sails to the first tick of that step.
  bool sail_to(std::size_t number) {
    for (int n = 0; n < 300'000 && voyage.is_on(); ++n) {
      step();
      if (!news.empty() && news.back().kind == Kind::kBegins && news.back().step == number) {
        return true;
      }
    }
    return false;
  }

  long count(Kind kind) const {
    return std::ranges::count_if(news, [&](const VoyageNews& one) { return one.kind == kind; });
  }
};

std::size_t first_of(Manoeuvre manoeuvre) {
  const auto found = std::ranges::find(kVoyageSteps, manoeuvre, &VoyageStep::manoeuvre);
  return static_cast<std::size_t>(found - kVoyageSteps.begin()) + 1;
}

TEST_CASE(
    "the table has every manoeuvre on both sides, and takes 20 minutes without the ways back") {
  using enum Manoeuvre;
  const auto of = [](Manoeuvre manoeuvre) {
    return std::ranges::count(kVoyageSteps, manoeuvre, &VoyageStep::manoeuvre);
  };
  CHECK(of(kAhead) == 3);
  CHECK(of(kAstern) == 3);
  CHECK(of(kZigZag) == 2);
  CHECK(of(kStraight) == 16);
  CHECK(of(kCircle) == 6);
  CHECK(of(kAlone) == 4);
  CHECK(kVoyageSteps.front().manoeuvre == kDrift);
  CHECK(kVoyageSteps.back().manoeuvre == kDrift);
  int seconds = 0;
  std::multiset<int> courses;
  for (const VoyageStep& step : kVoyageSteps) {
    seconds += step.driven_s + step.coasting_s;
    CHECK(std::abs(step.port) <= 100);
    CHECK(std::abs(step.stbd) <= 100);
    if (step.manoeuvre == kStraight) courses.insert(step.eighths_turn);
    // Each turn to one side has a mirror image to the other side.
    const auto twin = [&](const VoyageStep& other) {
      return other.manoeuvre == step.manoeuvre && other.port == step.stbd &&
             other.stbd == step.port;
    };
    const bool swaps = step.manoeuvre == kZigZag || step.manoeuvre == kRandom;
    CHECK((swaps || std::ranges::any_of(kVoyageSteps, twin)));
  }
  for (int course = 0; course < 8; ++course) CHECK(courses.count(course) == 2);
  CHECK(seconds > 16 * 60);
  CHECK(seconds < 20 * 60);
}

TEST_CASE_TEMPLATE("sails all steps in order, within its room, in about 25 minutes", S, float,
                   double, core::Q16) {
  Sea<S> sea;
  sea.sail(2400);
  REQUIRE_FALSE(sea.voyage.is_on());
  CHECK(sea.voyage.is_over());
  CHECK_FALSE(sea.voyage.is_lost());
  std::size_t expected = 1;
  for (const VoyageNews& one : sea.news) {
    if (one.kind != Kind::kBegins) continue;
    REQUIRE(one.step == expected);
    CHECK(one.what == name_of(kVoyageSteps[expected - 1].manoeuvre));
    ++expected;
  }
  CHECK(expected == kVoyageSteps.size() + 1);
  CHECK(sea.count(Kind::kAgain) == 0);
  REQUIRE(sea.news.back().kind == Kind::kOver);
  CHECK(sea.news.back().step == kVoyageSteps.size());
  CHECK(sea.t_s > 20 * 60);
  CHECK(sea.t_s < 28 * 60);
  CHECK(sea.farthest_m < 60);
}

TEST_CASE("drifts and coasts without thrust; spins with equal thrusts, one of them astern") {
  Sea<float> sea;
  REQUIRE(sea.sail_to(1));
  for (int n = 0; n < 5'000; ++n) {
    sea.step();
    REQUIRE(sea.shares.port == 0);
    REQUIRE(sea.shares.stbd == 0);
  }
  const std::size_t spin = first_of(Manoeuvre::kSpin);
  REQUIRE(sea.sail_to(spin));
  sea.step();
  CHECK(sea.shares.port == doctest::Approx(0.8 * 0.5));
  CHECK(sea.shares.stbd == -sea.shares.port);
  sea.sail(kVoyageSteps[spin - 1].driven_s);
  CHECK(sea.shares.port == 0);
  CHECK(sea.shares.stbd == 0);
}

TEST_CASE("zig-zags to 20 degrees on both sides") {
  Sea<float> sea;
  REQUIRE(sea.sail_to(first_of(Manoeuvre::kZigZag)));
  const double course = sea.psi;
  double least = 0, most = 0;
  int swaps = 0;
  core::Thrust<float> before = sea.shares;
  for (int n = 0; n < 3'900; ++n) {
    sea.step();
    if (sea.shares.port != before.port) ++swaps;
    before = sea.shares;
    least = std::min(least, std::remainder(sea.psi - course, 2 * M_PI));
    most = std::max(most, std::remainder(sea.psi - course, 2 * M_PI));
  }
  CHECK(least < -0.35);
  CHECK(most > 0.35);
  CHECK(least > -0.9);
  CHECK(most < 0.9);
  CHECK(swaps >= 4);
}

TEST_CASE("the random sequence repeats no six turns, and both sides are about equally frequent") {
  Sea<float> sea;
  REQUIRE(sea.sail_to(first_of(Manoeuvre::kRandom)));
  std::string sides;
  for (int second = 0; second < 62; ++second) {
    for (int n = 0; n < 100; ++n) sea.step();
    sides += sea.shares.port > sea.shares.stbd ? 'a' : 'b';
  }
  const auto a = std::ranges::count(sides, 'a');
  CHECK(a >= 30);
  CHECK(a <= 33);
  // Each window of six seconds occurs only once.
  std::set<std::string> windows;
  for (std::size_t n = 0; n + 6 <= sides.size(); ++n) windows.insert(sides.substr(n, 6));
  CHECK(windows.size() == sides.size() - 5);
}

TEST_CASE("a step cut short by a gust is repeated from the middle of its room") {
  Sea<float> sea;
  REQUIRE(sea.sail_to(kVoyageSteps.size()));
  sea.drift_mps = sea.east_m < 0 ? -1.5 : 1.5;
  for (int n = 0; n < 5'500 && sea.news.back().kind != Kind::kAgain; ++n) sea.step();
  sea.drift_mps = 0;
  REQUIRE(sea.news.back().kind == Kind::kAgain);
  CHECK(sea.news.back().what == "no room");
  CHECK(sea.farthest_m < 62);
  REQUIRE(sea.sail_to(kVoyageSteps.size()));
  CHECK(std::hypot(sea.north_m, sea.east_m) < 0.4 * 60);
  sea.sail(2400);
  CHECK(sea.voyage.is_over());
  CHECK(sea.news.back().step == kVoyageSteps.size());
}

TEST_CASE("a step without room is skipped after three tries, and reported") {
  Sea<float> sea(room(10));
  sea.sail(6000);
  REQUIRE(sea.voyage.is_over());
  CHECK(sea.count(Kind::kLeftOut) > 0);
  CHECK(sea.count(Kind::kAgain) >= 2 * sea.count(Kind::kLeftOut));
  CHECK(sea.news.back().step + static_cast<std::size_t>(sea.count(Kind::kLeftOut)) ==
        kVoyageSteps.size());
  CHECK(sea.farthest_m < 10);
}

TEST_CASE(
    "a step that was too fast is repeated with less thrust, and later steps get less thrust too") {
  Sea<float> sea;
  sea.thrust_N = 60;
  sea.sail(3600);
  REQUIRE(sea.voyage.is_over());
  CHECK(sea.news.back().step == kVoyageSteps.size());
  CHECK(sea.count(Kind::kAgain) >= 1);
  CHECK(sea.fastest_mps < 1.9);
  const auto again = std::ranges::find(sea.news, Kind::kAgain, &VoyageNews::kind);
  CHECK(again->what == "too fast");
}

TEST_CASE("a boat that was too fast ahead gets less thrust in later steps, except to spin") {
  Sea<float> sea;
  sea.thrust_N = 60;
  const std::size_t spin = first_of(Manoeuvre::kSpin);
  REQUIRE(sea.sail_to(spin));
  REQUIRE(sea.count(Kind::kAgain) >= 1);
  sea.step();
  CHECK(sea.shares.port == doctest::Approx(0.8 * 0.5));
  CHECK(sea.shares.stbd == -sea.shares.port);
  REQUIRE(sea.sail_to(first_of(Manoeuvre::kAlone)));
  sea.step();
  CHECK(sea.shares.port > 0);
  CHECK(sea.shares.port < 0.8 * 0.6 * 0.75);
  CHECK(sea.shares.stbd == 0);
}

TEST_CASE("a boat that turned too fast turns with less thrust, and is as fast ahead as before") {
  Sea<float> sea;
  sea.voyage.limit({.mps = 1.8F, .radps = 0.4F});
  REQUIRE(sea.sail_to(first_of(Manoeuvre::kCircle)));
  REQUIRE(sea.count(Kind::kAgain) >= 1);
  sea.step();
  CHECK(sea.shares.port + sea.shares.stbd == doctest::Approx(0.8 * 0.6));
  CHECK(sea.shares.port - sea.shares.stbd < 0.8 * 0.2 * 0.75);
  sea.sail(3600);
  CHECK(sea.voyage.is_over());
}

TEST_CASE("a fence ahead cuts a step short, as the edge of its room does") {
  Sea<float> sea;
  REQUIRE(sea.sail_to(2));
  sea.sail(2);
  CHECK(sea.shares.port > 0);
  sea.blocked = true;
  sea.step();
  CHECK(sea.shares.port == 0);
  CHECK(sea.news.back().what == "the fence");
}

TEST_CASE("a boat that waits has no thrust, and repeats the step without losing a try") {
  Sea<float> sea;
  REQUIRE(sea.sail_to(2));
  for (int pause = 0; pause < 5; ++pause) {
    sea.sail(5);
    CHECK(sea.shares.port > 0);
    sea.waits = true;
    sea.step();
    CHECK(sea.shares.port == 0);
    sea.sail(60);
    CHECK(sea.shares.port == 0);
    CHECK(sea.news.back().kind == Kind::kBegins);
    sea.waits = false;
    REQUIRE(sea.sail_to(2));
  }
}

TEST_CASE("continues with the interrupted step; another voyage starts from the beginning") {
  Sea<float> sea;
  REQUIRE(sea.sail_to(4));
  sea.sail(1);
  sea.voyage.interrupt();
  CHECK_FALSE(sea.voyage.is_on());
  sea.step();
  CHECK(sea.shares.port == 0);
  sea.begin(room());
  sea.news.clear();
  sea.sail(60);
  REQUIRE_FALSE(sea.news.empty());
  CHECK(sea.news.front().step == 4);
  VoyageRoom other = room();
  SUBCASE("a plan that began anew") { other.id.round = 8; }
  SUBCASE("another item") { other.id.item = 2; }
  SUBCASE("the same item after a jump") { other.id.jumps = 1; }
  sea.begin(other);
  sea.news.clear();
  sea.sail(60);
  CHECK(sea.news.front().step == 1);
}

TEST_CASE("a boat that does not come back is lost and stops") {
  SUBCASE("swept away") {
    Sea<float> sea;
    REQUIRE(sea.sail_to(2));
    sea.drift_mps = 100;
    sea.sail(1);
    CHECK(sea.voyage.is_lost());
    CHECK(sea.news.back().kind == Kind::kLost);
    CHECK(sea.shares.port == 0);
  }
  SUBCASE("its propellers are exchanged") {
    Sea<float> sea;
    sea.thrust_N = -20;
    sea.north_m = 40;
    sea.sail(600);
    CHECK(sea.voyage.is_lost());
  }
}

TEST_CASE("a plan's voyage needs a valid position, share of thrust and room") {
  const PlanDefaults defaults{.speed_mps = 0.5F, .radius_m = 2, .fastest_mps = 1.5F, .room_m = 60};
  const auto result = [&](const PlanItem& item) {
    return fault_of_last({&item, 1}, defaults).result;
  };
  CHECK(result(voyage_item()) == mav::kMissionAccepted);
  CHECK(result(voyage_item(1, 5)) == mav::kMissionAccepted);
  CHECK(result(voyage_item(NAN, NAN)) == mav::kMissionAccepted);
  CHECK(result(voyage_item(0.05F)) == mav::kMissionInvalidParam1);
  CHECK(result(voyage_item(1.1F)) == mav::kMissionInvalidParam1);
  CHECK(result(voyage_item(-0.5F)) == mav::kMissionInvalidParam1);
  CHECK(result(voyage_item(0, 4)) == mav::kMissionInvalidParam2);
  CHECK(result(voyage_item(0, INFINITY)) == mav::kMissionInvalidParam2);
  PlanItem nowhere = voyage_item();
  nowhere.x = nowhere.y = 0;
  CHECK(result(nowhere) != mav::kMissionAccepted);
  PlanItem local = voyage_item();
  local.frame = 1;
  CHECK(result(local) == mav::kMissionUnsupportedFrame);
  CHECK(room_of(voyage_item(), defaults, {1, 0.5F, 2}).radius_m == 60);
  CHECK(room_of(voyage_item(0.5F, 30), defaults, {1, 0.5F, 2}).radius_m == 30);
  CHECK(room_of(voyage_item(0.5F, 30), defaults, {1, 0.5F, 2}).share == 0.5F);
}

TEST_CASE("the plan is read up to a voyage, and beyond it if it is over") {
  const std::array plan{waypoint(410'000'000), voyage_item(), waypoint(410'001'000)};
  PlanReader reader;
  reader.begin({0}, {.speed_mps = 0.5F, .radius_m = 2});
  CHECK(reader.next(plan)->mark.item == 0);
  CHECK(reader.next(plan)->mark.item == 1);
  CHECK_FALSE(reader.next(plan));
  reader.begin({1}, {.speed_mps = 0.5F, .radius_m = 2});
  const auto centre = reader.next(plan);
  REQUIRE(centre);
  CHECK(centre->mark.item == 1);
  CHECK(centre->wait_s == 0);
  CHECK_FALSE(reader.next(plan));
  reader.begin({.first = 1, .voyage_is_over = true}, {.speed_mps = 0.5F, .radius_m = 2});
  CHECK(reader.next(plan)->mark.item == 1);
  CHECK(reader.next(plan)->mark.item == 2);
  CHECK_FALSE(reader.next(plan));
}

TEST_CASE("after a jump, a voyage that is over ends the reading again") {
  PlanItem jump;
  jump.command = mav::kDoJump;
  jump.param = {0, 3};
  const std::array plan{voyage_item(), waypoint(410'001'000), jump};
  PlanReader reader;
  reader.begin({.first = 0, .voyage_is_over = true}, {.speed_mps = 0.5F, .radius_m = 2});
  CHECK(reader.next(plan)->mark.item == 0);
  CHECK(reader.next(plan)->mark.item == 1);
  const auto again = reader.next(plan);
  REQUIRE(again);
  CHECK(again->mark.item == 0);
  CHECK(again->mark.jumps == 1);
  CHECK_FALSE(reader.next(plan));
}

}  // namespace
}  // namespace flotilla::app
