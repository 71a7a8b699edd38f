// SPDX-License-Identifier: MIT
// The assignment of a shape's places to boats, compared with all permutations and with the theorem.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

#include "app/fleet/assignment.hpp"
#include "app/fleet/move.hpp"

namespace flotilla::app {
namespace {

using Now = std::vector<std::optional<FleetSlot>>;

/// An outlook with a constant course and speed.
FleetOutlook straight(float ahead_mps, float heading_rad = 0) {
  return {.at = {{{ahead_mps, heading_rad, 0}}}, .most_mps = 1.5F};
}
const FleetOutlook kUnderWay = straight(0.6F);

/// Boats 1 … n, all behind boat 1.
FleetTable table_of(const std::vector<FleetSlot>& places) {
  FleetTable table{.epoch = 2, .assigns = true, .count = places.size()};
  for (std::size_t i = 0; i < places.size(); ++i) {
    table.members[i] = {.system = static_cast<std::uint8_t>(i + 1),
                        .leader = static_cast<std::uint8_t>(i == 0 ? 0 : 1),
                        .can_lead = true,
                        .length_dm = 12,
                        .slot_cm = places[i]};
  }
  return table;
}

double square(const FleetSlot& a, const FleetSlot& b) {
  return std::pow(a[0] - b[0], 2) + std::pow(a[1] - b[1], 2);
}

std::vector<FleetSlot> drawn(std::mt19937& generator, std::size_t count) {
  std::uniform_int_distribution<int> cm(-5000, 5000);
  std::vector<FleetSlot> places;
  while (places.size() < count) {
    const FleetSlot place{static_cast<std::int16_t>(cm(generator)),
                          static_cast<std::int16_t>(cm(generator))};
    const auto near = [&](const FleetSlot& other) { return square(place, other) < 400.0 * 400; };
    if (std::ranges::none_of(places, near)) places.push_back(place);
  }
  return places;
}

double nearest_cm(const FleetTable& table, const Now& now, std::size_t i, std::size_t j) {
  double least = std::numeric_limits<double>::max();
  for (int step = 0; step <= 1000; ++step) {
    const double s = step / 1000.0;
    std::array<double, 2> d{};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double before = (*now[i])[axis] - (*now[j])[axis];
      d[axis] =
          before + s * (table.members[i].slot_cm[axis] - table.members[j].slot_cm[axis] - before);
    }
    least = std::min(least, std::hypot(d[0], d[1]));
  }
  return least;
}

TEST_CASE("the assignment of slots minimises the sum of squared distances") {
  std::mt19937 generator(7);
  for (int round = 0; round < 200; ++round) {
    const std::size_t count = 2 + static_cast<std::size_t>(round) % 5;
    const auto now_at = drawn(generator, count), places = drawn(generator, count);
    const Now now(now_at.begin(), now_at.end());
    const FleetTable table = assigned(table_of(places), now, 0, kUnderWay, 0);
    double got = 0;
    for (std::size_t i = 0; i < count; ++i) got += square(table.members[i].slot_cm, now_at[i]);
    const bool leader_stays = table.members[0].slot_cm == places[0];
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), 0U);
    do {
      if (leader_stays && order[0] != 0) continue;
      double sum = 0;
      for (std::size_t i = 0; i < count; ++i) sum += square(places[order[i]], now_at[i]);
      CHECK(got <= sum);
    } while (std::ranges::next_permutation(order).found);
  }
}

TEST_CASE(
    "boats on straight paths stay 1.2 hull lengths apart, and 2 if the leader keeps its slot") {
  std::mt19937 generator(11);
  int led_from_elsewhere = 0;
  for (int round = 0; round < 300; ++round) {
    const std::size_t count = 2 + static_cast<std::size_t>(round) % 23;
    const auto now_at = drawn(generator, count), places = drawn(generator, count);
    const Now now(now_at.begin(), now_at.end());
    const FleetTable table = assigned(table_of(places), now, 0, kUnderWay, 0);
    const bool stays = table.members[0].slot_cm == places[0];
    led_from_elsewhere += stays ? 0 : 1;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t j = 0; j < i; ++j)
        CHECK(nearest_cm(table, now, i, j) > (stays ? 239.9 : 143.9));
    }
  }
  CHECK(led_from_elsewhere > 0);
  CHECK(led_from_elsewhere < 300);
}

TEST_CASE("each slot is assigned once, even if the positions of some boats are unknown") {
  std::mt19937 generator(13);
  for (std::size_t count = 1; count <= FleetTable::kMax; ++count) {
    auto places = drawn(generator, count);
    Now now(count);
    for (std::size_t i = 0; i < count; i += 2) now[i] = places[count - 1 - i];
    const FleetTable table = assigned(table_of(places), now, 0, kUnderWay, 0);
    std::vector<FleetSlot> given;
    for (const FleetMember& member : table.all()) given.push_back(member.slot_cm);
    std::ranges::sort(given);
    std::ranges::sort(places);
    CHECK(given == places);
    CHECK_FALSE(table.assigns);
  }
}

/// Duration of a move of two boats in which the second one goes to `to`, without kMoveRamp_s.
double seconds(FleetSlot from, FleetSlot to, const FleetOutlook& outlook, bool turns = false) {
  FleetTable requested = table_of({{0, 0}, to});
  requested.turns = turns;
  return assigned(requested, Now{FleetSlot{0, 0}, from}, 0, outlook, 0).move_ds / 10.0 -
         kMoveRamp_s;
}

TEST_CASE("a move takes as long as the longest path at the speed that the boats can reach") {
  constexpr double kMax = 0.97 * 1.5;
  const double abeam = std::sqrt(kMax * kMax - 0.36);
  CHECK(seconds({-400, 0}, {-400, 0}, kUnderWay) == -kMoveRamp_s);
  CHECK(seconds({-400, 0}, {-410, 0}, kUnderWay) == 10);
  CHECK(seconds({-400, 500}, {600, 500}, kUnderWay) ==
        doctest::Approx(10 / (kMax - 0.6)).epsilon(0.01));
  CHECK(seconds({-400, 0}, {-4400, 0}, kUnderWay) ==
        doctest::Approx(40 / (kMax + 0.6)).epsilon(0.01));
  CHECK(seconds({-400, 0}, {-400, 2000}, kUnderWay) == doctest::Approx(20 / abeam).epsilon(0.01));
  // At rest all directions take the same time; for a fleet that sails east, a place to the north is
  // abeam.
  CHECK(seconds({-400, 0}, {-2400, 0}, straight(0)) == doctest::Approx(20 / kMax).epsilon(0.01));
  CHECK(seconds({-400, 0}, {-2400, 0}, straight(0.6F, 1.5708F)) ==
        doctest::Approx(20 / abeam).epsilon(0.01));
}

TEST_CASE("paths are relative to the boat that leads, whatever its rank") {
  for (const std::size_t root : {0U, 1U}) {
    FleetTable requested = table_of({{0, 0}, {0, 0}});
    requested.members[root].slot_cm = {-400, 0};
    requested.members[1 - root].slot_cm = {2600, 0};
    const Now now{FleetSlot{-400, 0}, FleetSlot{-400, 0}};
    CHECK(assigned(requested, now, root, kUnderWay, 0).move_ds / 10.0 - kMoveRamp_s ==
          doctest::Approx(30 / (0.97 * 1.5 - 0.6)).epsilon(0.01));
  }
}

TEST_CASE("a turn of the leader changes a move's duration only if it comes during the move") {
  FleetOutlook turns_north = straight(0.6F, 1.5708F);
  turns_north.count = FleetOutlook::kMax;
  turns_north.at.fill(turns_north.at[0]);
  const double abeam_s = seconds({-3000, 500}, {0, 500}, turns_north);
  for (std::size_t k = 12; k < turns_north.count; ++k) turns_north.at[k].heading_rad = 0;
  const double ahead_s = seconds({-3000, 500}, {0, 500}, straight(0.6F));
  CHECK(ahead_s > abeam_s + 10);
  const double both_s = seconds({-3000, 500}, {0, 500}, turns_north);
  CHECK((abeam_s + 1 < both_s && both_s < ahead_s - 5));
  for (std::size_t k = 12; k < 16; ++k) turns_north.at[k].heading_rad = 1.5708F;
  CHECK(seconds({-3000, 500}, {0, 500}, turns_north) == abeam_s);
}

TEST_CASE("in a turning formation, outer boats have less speed left for their paths") {
  FleetOutlook turning = straight(0.6F);
  turning.at[0].turn_radps = 0.03F;
  const double outside_s = seconds({0, -1500}, {1500, -1500}, turning, true);
  CHECK(outside_s > seconds({0, -1500}, {1500, -1500}, straight(0.6F), true) + 10);
}

TEST_CASE("a leader that later sails faster slows down only the rest of the move") {
  constexpr double kSlow_mps = 0.33, kFast_mps = 0.6, kFrom_s = 60, kWay_m = 100, kIn_s = 7;
  FleetOutlook outlook = straight(static_cast<float>(kSlow_mps));
  outlook.count = FleetOutlook::kMax;
  outlook.at.fill(outlook.at[0]);
  for (std::size_t k = 30; k < outlook.count; ++k) outlook.at[k].ahead_mps = 0.6F;
  FleetTable requested = table_of({{0, 0}, {6000, 500}});
  const FleetTable table =
      assigned(requested, Now{FleetSlot{0, 0}, FleetSlot{-4000, 500}}, 0, outlook, kIn_s);
  const FleetPace pace{0.1 * table.move_ds, 0.1 * table.first_ds, table.first_share / kShares};
  CHECK(pace.all_s < kWay_m / (0.97 * 1.5 - kFast_mps) + kMoveRamp_s - 12);
  double fastest_mps = 0;
  for (double t_s = 0; t_s < pace.all_s; t_s += 0.1) {
    const double leader_mps = kIn_s + t_s < kFrom_s ? kSlow_mps : kFast_mps;
    const double mps = leader_mps + kWay_m * move_at(t_s, pace).rate;
    CHECK(mps < 0.97 * 1.5 + 1e-3);
    fastest_mps = std::max(fastest_mps, mps);
  }
  CHECK(fastest_mps > 0.97 * 1.5 - 0.01);
  requested.members[1].slot_cm = {-4000, 500};  // no boat moves
  CHECK(assigned(requested, Now{FleetSlot{0, 0}, FleetSlot{-4000, 500}}, 0, outlook, 0).move_ds ==
        0);
}

TEST_CASE("a move's speed is the derivative of its position and has no steps") {
  for (const FleetPace& pace :
       {FleetPace{0.5}, FleetPace{4}, FleetPace{10}, FleetPace{37.3}, FleetPace{60, 40, 0.4},
        FleetPace{60, 8, 0.9}, FleetPace{20, 19, 0.5}, FleetPace{20, 25, 0.5}}) {
    CAPTURE(pace.all_s);
    CAPTURE(pace.first_s);
    FleetMove last{.share = 0};
    constexpr double kStep_s = 1e-3;
    for (double t = 0; t < pace.all_s; t += kStep_s) {
      const FleetMove now = move_at(t, pace);
      CHECK(std::abs(now.share - last.share - kStep_s * (now.rate + last.rate) / 2) < 1e-5);
      const double steepest = std::max(std::abs(now.rate_dot), std::abs(last.rate_dot));
      CHECK(std::abs(now.rate - last.rate) <= 1.01 * kStep_s * steepest + 1e-9);
      CHECK(now.rate >= 0);
      last = now;
    }
    CHECK(last.share == doctest::Approx(1).epsilon(1e-3));
    CHECK(last.rate < 0.02);
    CHECK(move_at(pace.all_s, pace).share == 1);
    CHECK(move_at(pace.all_s, pace).rate == 0);
    CHECK(move_at(-1, pace).share == 0);
  }
  CHECK(move_at(0, {}).share == 1);
}

}  // namespace
}  // namespace flotilla::app
