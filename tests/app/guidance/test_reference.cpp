// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "app/guidance/reference.hpp"

namespace flotilla::app {
namespace {

constexpr std::int64_t kSecond_us = 1'000'000, kTick_us = 10'000;
constexpr link::GpsGlobalOrigin kOrigin{487'000'000, 22'950'000, 40'000, 0};
constexpr std::uint8_t kRoot = 100;
const convert::Position kHere{0, 0, kOrigin};

Parameters parameters(std::uint8_t system, std::uint8_t leader) {
  Parameters p;
  p.MAV_SYSID = system;
  p.FORM_LEADER = leader;
  p.FORM_OFS_N = -3;
  p.FORM_LAG_S = 0;  // few senders here answer TIMESYNC
  return p;
}

template <class S>
void configure(Reference<S>& reference, const Parameters& p, std::uint8_t system) {
  reference.configure(configuration_of(p).formation, convert::law_of<S>(p).foresight, system);
}

/// The root: a circle to starboard of 0.3 rad/s at 0.6 m/s.
struct Circle {
  static constexpr double kU = 0.6, kR = 0.3;
  static double psi(std::int64_t us) { return kR * static_cast<double>(us) * 1e-6; }
  static double north(std::int64_t us) { return kU / kR * std::sin(psi(us)); }
  static double east(std::int64_t us) { return kU / kR * (1 - std::cos(psi(us))); }

  static link::Odometry odometry(std::int64_t us) {
    link::Odometry m{};
    m.time_usec = static_cast<std::uint64_t>(us);
    m.x = static_cast<float>(north(us));
    m.y = static_cast<float>(east(us));
    m.q = {static_cast<float>(std::cos(0.5 * psi(us))), 0, 0,
           static_cast<float>(std::sin(0.5 * psi(us)))};
    m.vx = static_cast<float>(kU);
    m.yawspeed = static_cast<float>(kR);
    m.frame_id = 1;
    m.child_frame_id = 12;
    return m;
  }
};

/// A boat that receives only a reference; its clock is `ahead_us` ahead of the world's.
template <class S>
struct Boat {
  Reference<S> reference;
  VesselTrack<S> leader;
  std::int64_t ahead_us = 0;
  link::Address self;
  link::Counters counters;

  Boat(std::uint8_t system, std::uint8_t leader_system, std::int64_t clock_us)
      : leader({leader_system, 0}), ahead_us(clock_us), self{system, 1} {
    configure(reference, parameters(system, leader_system), system);
    leader.set_lag(0);
  }
  void hear(link::Address from, const link::Message& message, std::int64_t us) {
    leader.take({from, message}, us + ahead_us, counters);
    reference.take({from, message}, &kHere, us + ahead_us, counters);
  }
  std::optional<link::FormationReference> tell(std::int64_t us) const {
    return reference.message(us + ahead_us, true);
  }
  auto aim(std::int64_t us) const { return reference.aim(us + ahead_us); }
};

/// Distance of the aim from the root's true place, m.
template <class S>
double off_m(const Boat<S>& boat, std::int64_t us) {
  const auto aim = boat.aim(us);
  REQUIRE(aim);
  const double north = convert::number(aim->position.north_m) +
                       convert::number(aim->motion.moved_n.x) - Circle::north(us);
  const double east = convert::number(aim->position.east_m) +
                      convert::number(aim->motion.moved_n.y) - Circle::east(us);
  return std::hypot(north, east);
}

/// Boats in a line behind the root, with clocks hours apart; each hears its neighbours delay_us
/// late.
template <class S>
struct Line {
  static constexpr std::int64_t kDelay_us = 150'000;
  struct Sent {
    std::int64_t arrives_us;
    std::size_t to;
    link::Address from;
    link::Message message;
  };
  std::vector<Boat<S>> boats;
  std::vector<Sent> air;
  std::function<void(link::FormationReference&, std::size_t)> tamper = [](auto&, auto) {};
  bool root_speaks = true;

  explicit Line(std::uint8_t count) {
    for (std::uint8_t i = 1; i <= count; ++i) {
      const std::uint8_t leader = i == 1 ? kRoot : static_cast<std::uint8_t>(i - 1);
      boats.emplace_back(i, leader, 1000 * kSecond_us * (i % 5));
    }
  }

  void deliver(std::int64_t us) {
    std::vector<Sent> rest;
    for (const Sent& sent : air) {
      if (sent.arrives_us > us) {
        rest.push_back(sent);
      } else {
        boats[sent.to].hear(sent.from, sent.message, us);
      }
    }
    air = std::move(rest);
  }

  void answer_timesync(std::int64_t us) {
    for (std::size_t i = 0; i < boats.size(); ++i) {
      const auto exchange = [&](link::Address with, std::int64_t their_clock_us) {
        const std::int64_t sent_us = us - 2 * kDelay_us + boats[i].ahead_us;
        const std::int64_t read_us = us - kDelay_us + their_clock_us;
        boats[i].leader.answered(with, sent_us, read_us, us + boats[i].ahead_us);
        boats[i].reference.answered(with, sent_us, read_us, us + boats[i].ahead_us);
      };
      if (i == 0) exchange({kRoot, 1}, 0);
      if (i > 0) exchange(boats[i - 1].self, boats[i - 1].ahead_us);
      if (i + 1 < boats.size()) exchange(boats[i + 1].self, boats[i + 1].ahead_us);
    }
  }

  void run(std::int64_t from_us, std::int64_t to_us) {
    for (std::int64_t us = from_us; us < to_us; us += kTick_us) {
      if (us % 100'000 == 0 && root_speaks) {
        air.push_back({us + kDelay_us, 0, {kRoot, 1}, kOrigin});
        air.push_back({us + kDelay_us, 0, {kRoot, 1}, Circle::odometry(us)});
      }
      deliver(us);
      if (us % kSecond_us == 0) answer_timesync(us);
      for (std::size_t i = 0; i < boats.size(); ++i) {
        boats[i].reference.make(boats[i].leader, us + boats[i].ahead_us);
        if (us % 100'000 != 0) continue;
        auto said = boats[i].tell(us);
        if (!said) continue;
        tamper(*said, i);
        if (i > 0) air.push_back({us + kDelay_us, i - 1, boats[i].self, *said});
        if (i + 1 < boats.size()) air.push_back({us + kDelay_us, i + 1, boats[i].self, *said});
      }
    }
  }
};

TEST_CASE_TEMPLATE("a reference relayed by boats with clocks hours apart keeps the root's position",
                   S, float, double, core::Q16) {
  Line<S> line(8);
  line.run(0, 12 * kSecond_us);
  for (std::size_t i = 0; i < line.boats.size(); ++i) {
    CAPTURE(i);
    CHECK(off_m(line.boats[i], 12 * kSecond_us) < 0.02);
    const auto aim = line.boats[i].aim(12 * kSecond_us);
    CHECK(aim->branch == Branch{kRoot, 1});
    CHECK(aim->offset.n == convert::WireOffset{-3072 * (static_cast<int>(i) + 1), 0});
    CHECK(double(convert::number(aim->motion.nu.r)) == doctest::Approx(Circle::kR).epsilon(0.02));
    CHECK(line.boats[i].reference.place().depth(12 * kSecond_us + line.boats[i].ahead_us) == i + 1);
    CHECK(line.boats[i].counters.reference_refused == 0);
  }
}

TEST_CASE("each hop adds its own share to the age, and no more than a tick of waiting") {
  Line<double> line(6);
  line.run(0, 12 * kSecond_us);
  const auto age_us = [&](std::size_t i) {
    return *line.boats[i].reference.age_us(12 * kSecond_us + line.boats[i].ahead_us);
  };
  for (std::size_t i = 1; i < line.boats.size(); ++i) {
    CAPTURE(i);
    CHECK(age_us(i) > age_us(0) + static_cast<std::int64_t>(i) * 150'000 - 100'000);
    CHECK(age_us(i) <= age_us(0) + static_cast<std::int64_t>(i) * 260'000);
  }
}

TEST_CASE("with LAW_REF 0 a boat neither follows a reference nor sends one") {
  Line<double> line(3);
  auto p = parameters(2, 1);
  p.LAW_REF = 0;
  configure(line.boats[1].reference, p, 2);
  line.run(0, 6 * kSecond_us);
  CHECK_FALSE(line.boats[1].aim(6 * kSecond_us));
  CHECK_FALSE(line.boats[1].tell(6 * kSecond_us));
  CHECK(line.boats[0].aim(6 * kSecond_us));
}

TEST_CASE("a silent root is extrapolated for four seconds and sent for three") {
  Line<double> line(1);
  line.run(0, 6 * kSecond_us);  // the last message is of 5.9 s
  line.root_speaks = false;
  line.run(6 * kSecond_us, 8'850'000);
  CHECK(line.boats[0].tell(8'850'000));
  CHECK_FALSE(line.boats[0].tell(8'950'000));
  CHECK(line.boats[0].aim(9'850'000));
  CHECK_FALSE(line.boats[0].aim(9'950'000));
}

/// A boat behind boat 1, which sends the root's motion directly.
struct Follower {
  Boat<double> boat{2, 1, 0};
  std::uint16_t sequence = 0;

  static link::FormationReference reference(std::int64_t us, std::uint16_t sequence) {
    const convert::RootState<double> root{
        {Circle::north(us), Circle::east(us), kOrigin},
        {core::wrap_pi(Circle::psi(us)), {Circle::kU, 0, Circle::kR}, {}, 0}};
    link::FormationReference m = *convert::reference_of(root);
    m.time_boot_ms = static_cast<std::uint32_t>(us / 1000);
    m.sequence = sequence;
    m.root = kRoot;
    m.maker = 1;
    m.flags = link::mav::kReferenceFollowed;
    m.path[0] = kRoot;
    return m;
  }

  void hear(const link::FormationReference& m, std::int64_t us, std::uint8_t from = 1) {
    boat.hear({from, 1}, m, us);
  }
  /// Receives the true reference ten times a second.
  void hear_until(std::int64_t from_us, std::int64_t to_us) {
    for (std::int64_t us = from_us; us < to_us; us += 100'000) hear(reference(us, ++sequence), us);
  }
  std::uint32_t refused() const { return boat.counters.reference_refused; }
  std::uint32_t news() const { return boat.reference.news(); }
};

/// The future that boat 1 sends at `us`: the circle, then a straight from `straight_us` on.
link::FormationFuture future(std::int64_t us, std::uint16_t sequence, std::int64_t straight_us) {
  core::Future<double> f;
  for (std::size_t k = 0; k < f.u.size(); ++k) {
    const auto at_us = us + static_cast<std::int64_t>(k) * kSecond_us / 2;
    f.u[k] = Circle::kU;
    f.r[k] = at_us < straight_us ? Circle::kR : 0;
  }
  link::FormationFuture m = *convert::message_of(f);
  m.time_boot_ms = static_cast<std::uint32_t>(us / 1000);
  m.sequence = sequence;
  m.root = kRoot;
  m.maker = 1;
  return m;
}

/// Receives the circle from boat 1 until 2 s, then its future.
struct Foreseeing : Follower {
  /// Receives the last reference again, with a greater age.
  void repeat(std::int64_t us) {
    link::FormationReference m = reference(1'900'000, sequence);
    m.time_boot_ms = static_cast<std::uint32_t>(us / 1000);
    m.age_ms = static_cast<std::uint16_t>((us - 1'900'000) / 1000);
    hear(m, us);
  }

  explicit Foreseeing(std::int64_t straight_us) {
    hear_until(kSecond_us, 2 * kSecond_us);
    boat.hear({1, 1}, future(1'950'000, 1, straight_us), 1'960'000);
  }
  auto aim(std::int64_t us) {
    for (std::int64_t t = 1'970'000; t <= us; t += kTick_us) {
      if (t % kSecond_us == 0) repeat(t);
      boat.reference.make(boat.leader, t);
    }
    return boat.aim(us);
  }
};

TEST_CASE("an old reference is followed along the root's predicted motion") {
  Foreseeing f(4'000'000);
  const auto aim = f.aim(7'000'000);  // the reference is 5.1 s old
  REQUIRE(aim);
  CHECK(std::abs(aim->motion.nu.r) < 0.001);
  const double turned = aim->motion.psi - Circle::psi(4'280'000);  // half of it between two samples
  CHECK(std::abs(std::remainder(turned, 2 * M_PI)) < 0.03);
  CHECK(f.boat.reference.message(7'000'000, true));
  CHECK_FALSE(f.aim(11'000'000));  // older than 9 s
}

TEST_CASE("without a predicted motion, a reference of that age is not followed") {
  Follower f;
  f.hear_until(kSecond_us, 2 * kSecond_us);
  CHECK_FALSE(f.boat.aim(7'000'000));
}

TEST_CASE("a predicted motion that contradicts the reference is dropped") {
  Foreseeing f(2'000'000);  // the future is straight from now on
  REQUIRE(f.aim(2'400'000));
  CHECK(f.boat.reference.future_message(2'400'000));
  f.hear(Follower::reference(2'900'000, ++f.sequence), 2'910'000);  // but the root still turns
  f.boat.reference.make(f.boat.leader, 2'920'000);
  CHECK_FALSE(f.boat.reference.future_message(2'920'000));
  CHECK(off_m(f.boat, 3'000'000) < 0.01);
}

TEST_CASE("a prediction is relayed unchanged, with its age; those of other branches are ignored") {
  Foreseeing f(4'000'000);
  f.aim(2'500'000);
  const auto told = f.boat.reference.future_message(2'500'000);
  REQUIRE(told);
  CHECK(told->age_ms == 550);
  CHECK(told->root == kRoot);
  CHECK(told->maker == 1);
  CHECK(told->r_change == future(1'950'000, 1, 4'000'000).r_change);
  const std::uint32_t news = f.boat.reference.future_news();
  auto other = future(2'500'000, 9, 4'000'000);
  other.maker = 9;
  f.boat.hear({1, 1}, other, 2'510'000);
  auto impossible = future(2'500'000, 9, 4'000'000);
  impossible.u = 32'000;
  f.boat.hear({1, 1}, impossible, 2'510'000);
  f.boat.hear({1, 1}, future(1'950'000, 1, 4'000'000), 2'510'000);  // again
  CHECK(f.boat.reference.future_news() == news);
  CHECK(f.boat.counters.mavlink_bad_value == 1);
}

TEST_CASE("a repeated or older reference changes nothing") {
  Follower f;
  f.hear_until(kSecond_us, 2 * kSecond_us);
  const std::uint32_t news = f.news();
  CHECK(news == 10);
  const auto again = Follower::reference(1'900'000, f.sequence);
  f.hear(again, 1'950'000);
  f.hear(again, 1'960'000, 5);
  f.hear(Follower::reference(1'800'000, static_cast<std::uint16_t>(f.sequence - 1)), 1'970'000, 6);
  CHECK(f.news() == news);
  CHECK(off_m(f.boat, 2 * kSecond_us) < 0.01);
}

TEST_CASE("a leader's new slot is kept when late copies of earlier messages arrive") {
  Follower f;
  f.hear_until(kSecond_us, 2 * kSecond_us);
  for (std::int64_t us = 2 * kSecond_us; us < 3 * kSecond_us; us += 100'000) {
    auto now = Follower::reference(us, ++f.sequence), before = Follower::reference(us - 500'000, 0);
    before.sequence = static_cast<std::uint16_t>(f.sequence - 5);
    now.offset_n = {2048, 0};
    f.hear(now, us);
    f.hear(before, us + 10'000);
    CHECK(f.boat.aim(us + 20'000)->offset.n == convert::WireOffset{2048 - 3072, 0});
  }
}

TEST_CASE("of 100 references a second only 20 are used, and the root is still known within 1 cm") {
  Follower f;
  for (std::int64_t us = kSecond_us; us < 2 * kSecond_us; us += kTick_us) {
    f.hear(Follower::reference(us, ++f.sequence), us);
  }
  CHECK(f.news() == 20);
  CHECK(off_m(f.boat, 2 * kSecond_us) < 0.01);
}

TEST_CASE("a sequence number that wraps after 65536 continues") {
  Follower f;
  f.sequence = 65'530;
  f.hear_until(kSecond_us, 3 * kSecond_us);
  CHECK(f.news() == 20);
}

TEST_CASE("a boat that makes references and restarts is followed again after its first second") {
  Follower f;
  f.sequence = 5000;
  f.hear_until(kSecond_us, 3 * kSecond_us);
  f.sequence = 0;
  f.hear_until(3 * kSecond_us, 6 * kSecond_us);
  CHECK(f.news() >= 20 + 18);
  CHECK(off_m(f.boat, 6 * kSecond_us) < 0.01);
}

TEST_CASE(
    "a newer reference is accepted from any boat of the branch, and never for another branch") {
  Follower f;
  f.hear_until(kSecond_us, 2 * kSecond_us);
  const std::uint32_t news = f.news();
  f.hear(Follower::reference(2'050'000, ++f.sequence), 2'060'000, 9);
  CHECK(f.news() == news + 1);
  auto other = Follower::reference(2'100'000, ++f.sequence);
  other.maker = 4;
  f.hear(other, 2'110'000, 9);
  other.maker = 1;
  other.root = 101;
  f.hear(other, 2'110'000, 9);
  CHECK(f.news() == news + 1);
}

TEST_CASE("another boat's claim about its own slot and path is ignored") {
  Follower f;
  f.hear_until(kSecond_us, 2 * kSecond_us);
  auto sibling = Follower::reference(2'050'000, ++f.sequence);
  sibling.offset_n = {99'999, 99'999};
  sibling.path[0] = 2;
  f.hear(sibling, 2'060'000, 9);
  CHECK(f.boat.aim(2'100'000)->offset.n == convert::WireOffset{-3072, 0});
  CHECK_FALSE(f.boat.reference.place().is_cycle(2'100'000));
}

TEST_CASE("a reference that arrives too old is refused, as is one at an impossible position") {
  Follower f;
  f.hear_until(kSecond_us, 2 * kSecond_us);
  const std::uint32_t news = f.news();
  auto old = Follower::reference(2'050'000, ++f.sequence);
  old.age_ms = 5000;
  f.hear(old, 2'060'000, 9);
  CHECK(f.refused() == 1);
  auto nowhere = Follower::reference(2'050'000, ++f.sequence);
  nowhere.latitude = nowhere.longitude = 0;
  f.hear(nowhere, 2'060'000);
  CHECK(f.boat.counters.mavlink_bad_value == 1);
  CHECK(f.news() == news);
}

TEST_CASE("a root that jumps is followed only after it has stayed there for a second") {
  for (const std::uint8_t liar : {std::uint8_t{1}, std::uint8_t{9}}) {
    Follower f;
    f.hear_until(kSecond_us, 3 * kSecond_us);
    const std::uint32_t news = f.news();
    for (std::int64_t us = 3 * kSecond_us; us < 3'900'000; us += 100'000) {
      auto m = Follower::reference(us, ++f.sequence);
      m.east += 20 * 1024;
      f.hear(m, us, liar);
    }
    CHECK(f.news() == news);
    CHECK(f.refused() == 9);
    CHECK_FALSE(f.boat.reference.jumped());
    CHECK(off_m(f.boat, 3'900'000) < 0.02);
    for (std::int64_t us = 3'900'000; us < 4'400'000; us += 100'000) {
      auto m = Follower::reference(us, ++f.sequence);
      m.east += 20 * 1024;
      f.hear(m, us, liar);
    }
    CHECK(f.news() > news);
    CHECK(f.boat.reference.jumped());
    f.boat.reference.accept_place();
    CHECK_FALSE(f.boat.reference.jumped());
  }
}

TEST_CASE("a root that jumps because another boat now makes its reference is not followed either") {
  Follower f;
  f.hear_until(kSecond_us, 3 * kSecond_us);
  auto m = Follower::reference(3 * kSecond_us, ++f.sequence);
  m.maker = 9;
  m.east += 20 * 1024;
  f.hear(m, 3 * kSecond_us);
  CHECK(f.refused() == 1);
  CHECK_FALSE(f.boat.aim(3 * kSecond_us));
}

TEST_CASE("a refused reference is not relayed") {
  Follower f;
  f.hear_until(kSecond_us, 3 * kSecond_us);
  auto jump = Follower::reference(3 * kSecond_us, ++f.sequence);
  const auto good = f.boat.tell(3 * kSecond_us)->north;
  jump.north += 50 * 1024;
  f.hear(jump, 3 * kSecond_us);
  CHECK(f.boat.tell(3 * kSecond_us)->north == good);
}

TEST_CASE("a root with another origin is not followed at once either") {
  Follower f;
  f.hear_until(kSecond_us, 3 * kSecond_us);
  const std::uint32_t news = f.news();
  auto m = Follower::reference(3 * kSecond_us, ++f.sequence);
  m.latitude += 100'000;
  f.hear(m, 3 * kSecond_us);
  CHECK(f.news() == news);
  CHECK(f.refused() == 1);
}

TEST_CASE("a root that is farther away than FORM_DIST_MAX from our slot is not followed") {
  for (const int away_m : {190, 210, 6000}) {
    Follower f;
    for (std::int64_t us = kSecond_us; us < 2 * kSecond_us; us += 100'000) {
      auto m = Follower::reference(us, ++f.sequence);
      m.north += away_m * 1024;
      f.hear(m, us);
    }
    CHECK(f.boat.aim(2 * kSecond_us).has_value() == (away_m < 200));
  }
}

TEST_CASE("without its own position a boat follows no other boat's reference") {
  Follower f;
  f.boat.reference.take({{1, 1}, Follower::reference(kSecond_us, 1)}, nullptr, kSecond_us,
                        f.boat.counters);
  CHECK_FALSE(f.boat.aim(kSecond_us));
}

TEST_CASE("a leader out of its slot is followed directly, by a reference made on board") {
  Follower f;
  const auto track_leader = [&](std::int64_t us) {
    f.boat.leader.take({{1, 1}, kOrigin}, us, f.boat.counters);
    f.boat.leader.take({{1, 1}, Circle::odometry(us)}, us, f.boat.counters);
    f.boat.reference.make(f.boat.leader, us);
  };
  for (std::int64_t us = kSecond_us; us < 3 * kSecond_us; us += 100'000) {
    track_leader(us);
    f.hear(Follower::reference(us, ++f.sequence), us);
  }
  CHECK(f.boat.aim(3 * kSecond_us)->branch == Branch{kRoot, 1});
  auto left = Follower::reference(3 * kSecond_us, ++f.sequence);
  left.flags = 0;
  f.hear(left, 3 * kSecond_us);
  track_leader(3 * kSecond_us);
  CHECK(f.boat.aim(3 * kSecond_us)->branch == Branch{1, 2});
  CHECK(f.boat.tell(3 * kSecond_us)->maker == 2);
  CHECK(f.boat.tell(3 * kSecond_us)->path[1] == kRoot);
}

TEST_CASE("a reference of unknown age is relayed as such, and is not followed") {
  Follower f;
  Parameters unknown = parameters(2, 1);
  unknown.FORM_LAG_S = -1;
  configure(f.boat.reference, unknown, 2);
  f.hear_until(kSecond_us, 2 * kSecond_us);
  CHECK_FALSE(f.boat.aim(2 * kSecond_us));
  CHECK_FALSE(f.boat.reference.age_us(2 * kSecond_us));
  CHECK((f.boat.tell(2 * kSecond_us)->flags & link::mav::kReferenceUntimed) != 0);
  f.boat.reference.answered({1, 1}, 1'950'000, 1'960'000, 1'970'000);
  f.hear_until(2 * kSecond_us, 2'200'000);
  CHECK(f.boat.aim(2'200'000));
  auto unsure = Follower::reference(2'300'000, ++f.sequence);
  unsure.flags |= link::mav::kReferenceUntimed;
  f.hear(unsure, 2'300'000);
  CHECK_FALSE(f.boat.aim(2'300'000));
}

TEST_CASE("the age of a reference includes its clock's greatest error") {
  Follower f;
  for (std::int64_t us = kSecond_us; us < 6 * kSecond_us; us += 100'000) {
    f.boat.reference.answered({1, 1}, us - 1000, us + 4'200'000, us);  // asked long ago, perhaps
    f.hear(Follower::reference(us, ++f.sequence), us);
  }
  CHECK_FALSE(f.boat.aim(6 * kSecond_us));
  CHECK(f.refused() > 0);
}

TEST_CASE("a boat that changes its leader discards the old leader's reference") {
  Follower f;
  f.hear_until(kSecond_us, 2 * kSecond_us);
  CHECK(f.boat.aim(2 * kSecond_us));
  configure(f.boat.reference, parameters(2, 7), 2);
  CHECK_FALSE(f.boat.aim(2 * kSecond_us));
  CHECK_FALSE(f.boat.tell(2 * kSecond_us));
}

TEST_CASE("the age is sent in milliseconds, relative to the whole millisecond of the stamp") {
  Follower f;
  f.hear_until(kSecond_us, 2 * kSecond_us);
  const auto said = f.boat.tell(2'345'678);
  REQUIRE(said);
  CHECK(said->time_boot_ms == 2345);
  CHECK(said->age_ms == 445);  // the last one was true at 1.9 s
  CHECK(said->flags == link::mav::kReferenceFollowed);
  CHECK(f.boat.reference.message(2'345'678, false)->flags == 0);
}

}  // namespace
}  // namespace flotilla::app
