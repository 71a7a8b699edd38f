// SPDX-License-Identifier: MIT
// Vessels whose messages are late, overtaken, or stamped by a clock that changes.
#include <doctest/doctest.h>

#include <cmath>

#include "app/navigation/neighbours_watch.hpp"

namespace flotilla::app::vessels {
namespace {

/// Vessel 5 sails north at 2 m/s. It reports its place at `true_us` by a clock that is `ahead_us`
/// ahead of ours.
struct Sailing : Watch {
  std::int64_t ahead_us = 100 * kSecond_us;

  Sailing() { hear(5, beat()); }
  void tell(std::int64_t true_us, std::int64_t now_us) {
    link::GlobalPositionInt m = at(2e-6 * static_cast<double>(true_us), 0, 2, 0);
    m.time_boot_ms = static_cast<std::uint32_t>((true_us + ahead_us) / 1000);
    hear(5, m, now_us);
  }
  /// Reports ten times a second, each `late_us` late.
  void sail(std::int64_t from_us, std::int64_t to_us, std::int64_t late_us) {
    for (std::int64_t us = from_us; us < to_us; us += 100'000) tell(us - late_us, us);
  }
  /// Distance of the assumed place ahead of the true one, without the assumed delay of 0.1 s.
  double off_m(std::int64_t now_us) const {
    const auto seen = look(now_us);
    REQUIRE(seen.count == 1);
    return seen.vessels[0].p_n.x - 2e-6 * static_cast<double>(now_us) - 0.2;
  }
};

TEST_CASE("a late state is as old as its stamp, and its position as uncertain") {
  Sailing w;
  w.sail(0, kSecond_us, 0);
  CHECK(w.off_m(kSecond_us) == doctest::Approx(0).epsilon(0.05));
  w.sail(2 * kSecond_us, 3 * kSecond_us, 800'000);
  CHECK(w.off_m(3 * kSecond_us) == doctest::Approx(0).epsilon(0.05));
  CHECK(w.look(3 * kSecond_us).vessels[0].margin ==
        doctest::Approx(2 * (0.1 + 0.1 + 0.8)).epsilon(0.01));
}

TEST_CASE("a state five to thirty seconds late is as old as its stamp, and that is reported") {
  for (const std::int64_t late_us : {5 * kSecond_us, 29 * kSecond_us}) {
    Sailing w;
    w.sail(0, 10 * kSecond_us, 0);
    CHECK_FALSE(w.neighbours.late(10 * kSecond_us));
    w.sail(12 * kSecond_us, 60 * kSecond_us, late_us);
    CHECK(w.off_m(60 * kSecond_us) == doctest::Approx(0).epsilon(0.15));
    CHECK(w.look(60 * kSecond_us).vessels[0].margin ==
          doctest::Approx(2 * (0.2 + 1e-6 * static_cast<double>(late_us))).epsilon(0.01));
    CHECK(w.neighbours.late(60 * kSecond_us) == 5);
    w.tell(60 * kSecond_us, 60 * kSecond_us);
    CHECK(w.neighbours.late(60 * kSecond_us) == 5);  // another one with its id may be the late one
    CHECK_FALSE(w.neighbours.late(63 * kSecond_us));
    CHECK(w.off_m(60 * kSecond_us) == doctest::Approx(0).epsilon(0.05));
  }
}

TEST_CASE("a vessel heard late counts until it has been silent for 3 s") {
  Sailing w;
  w.sail(0, 10 * kSecond_us, 0);
  w.sail(10 * kSecond_us, 20 * kSecond_us, 8 * kSecond_us);
  CHECK(w.look(22 * kSecond_us + 800'000).count == 1);
  CHECK(w.look(23 * kSecond_us).count == 0);
}

TEST_CASE("a vessel heard 40 s late is predicted for 30 s, and then taken for prompt") {
  Sailing w;
  w.sail(0, 10 * kSecond_us, 0);
  w.sail(10 * kSecond_us, 39 * kSecond_us, 40 * kSecond_us);
  CHECK(w.off_m(39 * kSecond_us) == doctest::Approx(0).epsilon(0.15));
  CHECK(w.neighbours.late(39 * kSecond_us) == 5);
  w.sail(39 * kSecond_us, 45 * kSecond_us, 40 * kSecond_us);
  CHECK(w.off_m(45 * kSecond_us) == doctest::Approx(-80).epsilon(0.01));
}

TEST_CASE("a vessel whose clock is set back is predicted from its last state until then") {
  Sailing w;
  w.ahead_us = 1000 * kSecond_us;
  w.sail(5 * kSecond_us, 20 * kSecond_us, 0);
  w.ahead_us -= 15 * kSecond_us;
  for (std::int64_t us = 20 * kSecond_us; us < 34 * kSecond_us; us += kSecond_us) {
    w.tell(us, us);
    const auto seen = w.look(us + 500'000);
    CHECK(seen.count == (us < 23 * kSecond_us ? 2 : 1));  // its new clock may be another vessel's
    for (std::size_t k = 0; k < seen.count; ++k) {
      const double off_m = seen.vessels[k].p_n.x - 2e-6 * static_cast<double>(us + 500'000) - 0.2;
      CHECK(off_m == doctest::Approx(0).epsilon(0.25));
    }
  }
}

TEST_CASE("the first prompt message shows that a vessel's earlier messages were late") {
  Sailing w;
  w.sail(5 * kSecond_us, 6 * kSecond_us, 4 * kSecond_us);
  w.sail(6 * kSecond_us, 7 * kSecond_us, 0);
  w.sail(8 * kSecond_us, 9 * kSecond_us, kSecond_us);
  CHECK(w.off_m(9 * kSecond_us) == doctest::Approx(0).epsilon(0.05));
}

TEST_CASE("an overtaken message does not move a vessel back") {
  Sailing w;
  w.sail(0, 2 * kSecond_us, 0);
  const double before_m = w.off_m(2 * kSecond_us);
  w.tell(kSecond_us, 2 * kSecond_us);
  CHECK(w.off_m(2 * kSecond_us) == before_m);
}

TEST_CASE("a restarted or changed clock hides its vessel for at most three seconds") {
  for (const std::int64_t ahead_us : {-5 * kSecond_us, 35 * kSecond_us, 4000 * kSecond_us}) {
    Sailing w;
    w.sail(5 * kSecond_us, 10 * kSecond_us, 0);
    w.ahead_us = ahead_us;
    w.sail(10 * kSecond_us, 14 * kSecond_us, 0);
    CHECK(w.off_m(14 * kSecond_us) == doctest::Approx(0).epsilon(0.05));
  }
}

TEST_CASE("after a clock was set back, or one stamp was wrong, the margin covers the vessel") {
  for (const bool set_back : {true, false}) {
    for (const std::int64_t by_us : {10 * kSecond_us, 40 * kSecond_us}) {
      Sailing w;
      w.ahead_us = 1000 * kSecond_us;
      w.sail(5 * kSecond_us, 10 * kSecond_us, 0);
      if (set_back) {
        w.ahead_us -= by_us;
      } else {
        w.ahead_us += by_us;
        w.tell(10 * kSecond_us, 10 * kSecond_us);
        w.ahead_us -= by_us;
      }
      w.sail(10 * kSecond_us + 100'000, 75 * kSecond_us, 0);
      if (by_us > 30 * kSecond_us) {
        CHECK(w.off_m(75 * kSecond_us) == doctest::Approx(0).epsilon(0.05));
      } else {
        CHECK(std::abs(w.off_m(75 * kSecond_us)) < w.look(75 * kSecond_us).vessels[0].margin);
      }
    }
  }
}

TEST_CASE("a vessel beside us is not clear of us although its late states are of another place") {
  Sailing w;
  w.sail(0, 20 * kSecond_us, 0);
  w.sail(25 * kSecond_us, 26 * kSecond_us, 10 * kSecond_us);
  w.own.north_m = 31.5;
  w.sail(26 * kSecond_us, 27 * kSecond_us, 10 * kSecond_us);
  CHECK_FALSE(w.neighbours.clear(w.own, core::Vec2<float>{}, 27 * kSecond_us));
}

TEST_CASE("a vessel that was started while it was silent is heard again") {
  Sailing w;
  w.ahead_us = 20 * kSecond_us;
  w.sail(5 * kSecond_us, 10 * kSecond_us, 0);
  w.ahead_us = -14 * kSecond_us;
  w.sail(15 * kSecond_us, 16 * kSecond_us, 0);
  CHECK(w.off_m(16 * kSecond_us) == doctest::Approx(0).epsilon(0.05));
}

TEST_CASE("when the fast link is lost, states from the slow one are late, not from a new clock") {
  for (const std::int64_t late_us : {2 * kSecond_us, 6 * kSecond_us, 25 * kSecond_us}) {
    Sailing w;
    w.ahead_us = 1000 * kSecond_us;
    for (std::int64_t us = 0; us < 120 * kSecond_us; us += 100'000) {
      if (us < 70 * kSecond_us) w.tell(us, us);
      if (us >= late_us) w.tell(us - late_us, us);
    }
    CHECK(w.neighbours.late(120 * kSecond_us).has_value() == (late_us > 3 * kSecond_us));
    CHECK(std::abs(w.off_m(120 * kSecond_us)) < 0.2);
  }
}

TEST_CASE("a clock slower than ours for hours does not age its vessel") {
  Sailing w;
  constexpr std::int64_t kHours_us = 4 * 3600 * kSecond_us;
  for (std::int64_t us = 0; us <= kHours_us; us += 500'000) {
    link::GlobalPositionInt m = at(0, 0, 2, 0);
    m.time_boot_ms = static_cast<std::uint32_t>((us - us / 10'000) / 1000);  // 100 ppm
    w.hear(5, m, us);
  }
  CHECK(w.look(kHours_us).vessels[0].p_n.x == doctest::Approx(0.2).epsilon(0.05));
}

TEST_CASE("two vessels with one system id both count, whatever the time between their starts") {
  for (const std::int64_t apart_us :
       {0 * kSecond_us, 5 * kSecond_us, -5 * kSecond_us, 400 * kSecond_us, -400 * kSecond_us}) {
    CAPTURE(apart_us);
    Sailing one;
    const auto tell_other = [&](double north_m, std::int64_t now_us) {
      link::GlobalPositionInt m = at(north_m, 60, -1, 0);
      m.time_boot_ms = static_cast<std::uint32_t>((now_us + one.ahead_us + apart_us) / 1000);
      one.hear(5, m, now_us);
    };
    one.ahead_us = 1000 * kSecond_us;
    for (std::int64_t us = 0; us < 20 * kSecond_us; us += 200'000) {
      one.tell(us, us);
      tell_other(20 - 1e-6 * static_cast<double>(us), us + 100'000);
    }
    const auto seen = one.look(20 * kSecond_us);
    REQUIRE(seen.count == 2);
    CHECK(seen.vessels[0].p_n.x == doctest::Approx(40.2).epsilon(0.02));
    CHECK(seen.vessels[1].p_n.y == doctest::Approx(60).epsilon(0.02));
    CHECK(seen.vessels[1].stranger);
    CHECK(one.look(24 * kSecond_us).count == 0);
  }
}

TEST_CASE("one vessel is never two: fast or slow, late or not") {
  for (const double speed_mps : {0.0, 2.0, 8.0}) {
    Watch w;
    w.hear(5, beat());
    const auto tell = [&](std::int64_t true_us, std::int64_t now_us) {
      const double t_s = 1e-6 * static_cast<double>(true_us), turn = 0.05 * t_s;
      link::GlobalPositionInt m =
          at(speed_mps / 0.05 * std::sin(turn), speed_mps / 0.05 * (1 - std::cos(turn)),
             speed_mps * std::cos(turn), speed_mps * std::sin(turn));
      m.time_boot_ms = static_cast<std::uint32_t>((true_us + 1000 * kSecond_us) / 1000);
      w.hear(5, m, now_us);
    };
    for (std::int64_t us = 0; us < 120 * kSecond_us; us += 1'000'000) {
      tell(us, us);
      if (us >= 10 * kSecond_us) tell(us - 10 * kSecond_us, us);
      CHECK(w.look(us).count == 1);
    }
  }
}

TEST_CASE("a vessel alongside is not clear of us although one with its system id is far away") {
  Watch w;
  w.hear(5, beat());
  const auto tell = [&](double north_m, std::int64_t stamp_us, std::int64_t now_us) {
    link::GlobalPositionInt m = at(north_m, 0);
    m.time_boot_ms = static_cast<std::uint32_t>(stamp_us / 1000);
    w.hear(5, m, now_us);
  };
  const auto clear = [&](std::int64_t now_us) {
    return w.neighbours.clear(w.own, core::Vec2<float>{}, now_us);
  };
  for (std::int64_t us = 0; us < 10 * kSecond_us; us += 200'000) {
    tell(-200, us + 100 * kSecond_us, us);
    if (us < 2 * kSecond_us) {
      CHECK(clear(us));
    } else {
      tell(-0.5, us + 40 * kSecond_us, us + 100'000);
      CHECK_FALSE(clear(us + 100'000));
    }
  }
  CHECK(w.look(10 * kSecond_us).count == 2);
  CHECK(clear(13 * kSecond_us));
}

}  // namespace
}  // namespace flotilla::app::vessels
