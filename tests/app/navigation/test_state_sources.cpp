// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cstdlib>

#include "app/navigation/state_sources.hpp"

namespace flotilla::app {
namespace {

constexpr std::int64_t kPeriod_us = 100'000;

/// A vessel that sends all its sources ten times a second.
struct Rounds {
  StateSources sources{500'000};
  std::int64_t now_us = 1'000'000;
  bool origin_known = true;

  void hear(Source source, std::int64_t stamp_us) {
    sources.hear(source, stamp_us, now_us, true);
    if (source == sources.in_use()) sources.clock().heard(stamp_us, now_us);
    if (source == sources.in_use() || !sources.better(source, now_us, origin_known)) return;
    sources.change_to(source);
  }
  void sail(int rounds, std::initializer_list<Source> of) {
    for (int k = 0; k < rounds; ++k, now_us += kPeriod_us) {
      for (const Source source : of) hear(source, now_us);
    }
  }
};

constexpr Source kOdometry = Source::kOdometry, kLocal = Source::kLocalPosition,
                 kFollow = Source::kFollowTarget, kGlobal = Source::kGlobalPosition;

TEST_CASE("after half a second of silence a source is replaced by the next best") {
  Rounds r;
  r.sail(10, {kGlobal, kFollow, kLocal, kOdometry});
  CHECK(r.sources.in_use() == kOdometry);
  r.sail(5, {kGlobal, kFollow, kLocal});  // the last of it is exactly half a second later
  CHECK(r.sources.in_use() == kOdometry);
  r.hear(kGlobal, r.now_us);
  r.hear(kFollow, r.now_us);
  CHECK(r.sources.in_use() == kOdometry);  // a better one is about to come
  r.hear(kLocal, r.now_us);
  CHECK(r.sources.in_use() == kLocal);
}

TEST_CASE("a better source is used again at its fifth message without a gap") {
  Rounds r;
  r.sail(10, {kGlobal});
  r.sail(4, {kGlobal, kFollow});
  CHECK(r.sources.in_use() == kGlobal);
  r.sail(5, {kGlobal});  // a gap
  r.sail(4, {kGlobal, kFollow});
  CHECK(r.sources.in_use() == kGlobal);
  r.sail(3, {kGlobal});  // none: the messages before count
  r.sail(1, {kGlobal, kFollow});
  CHECK(r.sources.in_use() == kFollow);
}

TEST_CASE("a more precise source that is later is not chosen while the prompt one comes") {
  for (const std::int64_t late_us : {200'000, 400'000, 3'000'000}) {
    Rounds r;
    r.now_us = 100'000'000;
    r.sail(10, {kGlobal});
    for (int k = 0; k < 20; ++k, r.now_us += kPeriod_us) {
      r.hear(kGlobal, r.now_us);
      r.hear(kOdometry, r.now_us - late_us);
    }
    const bool prompt = late_us < 300'000;
    CHECK(r.sources.in_use() == (prompt ? kOdometry : kGlobal));
    for (int k = 0; k < 10; ++k, r.now_us += kPeriod_us) r.hear(kOdometry, r.now_us - late_us);
    CHECK(r.sources.in_use() == kOdometry);  // better than none
    const std::int64_t age_us = late_us - *r.sources.clock().offset_us();
    CHECK(std::abs(age_us - (prompt ? 0 : late_us)) < 1000);
    for (int k = 0; k < 20; ++k, r.now_us += kPeriod_us) {
      r.hear(kOdometry, r.now_us - late_us);
      r.hear(kGlobal, r.now_us);
    }
    CHECK(r.sources.in_use() == (prompt ? kOdometry : kGlobal));
    for (int k = 0; k < 10; ++k, r.now_us += kPeriod_us) r.hear(kGlobal, r.now_us);
    for (int k = 0; k < 20; ++k, r.now_us += kPeriod_us) {
      r.hear(kOdometry, r.now_us - late_us);
      r.hear(kGlobal, r.now_us);
    }
    CHECK(r.sources.in_use() == (prompt ? kOdometry : kGlobal));
    r.sail(10, {kGlobal, kOdometry});
    CHECK(r.sources.in_use() == kOdometry);
  }
}

TEST_CASE("a late source that came first is replaced by a prompt one, which comes more seldom") {
  Rounds r;
  r.now_us = 100'000'000;
  for (int k = 0; k < 30; ++k, r.now_us += kPeriod_us) {
    r.hear(kOdometry, r.now_us - 2'000'000);
    if (k % 3 == 0) r.hear(kGlobal, r.now_us);
  }
  CHECK(r.sources.in_use() == kGlobal);
}

TEST_CASE("sources that count from other instants are not late") {
  Rounds r;
  r.now_us = 500'000'000;
  r.sail(10, {kGlobal});
  for (int k = 0; k < 20; ++k, r.now_us += kPeriod_us) {
    r.hear(kGlobal, r.now_us);
    r.hear(kOdometry, r.now_us - 400'000'000);
  }
  CHECK(r.sources.in_use() == kOdometry);
  CHECK(*r.sources.clock().offset_us() == doctest::Approx(400e6).epsilon(1e-4));
}

TEST_CASE("a source heard first after a restart is not late by the time that the vessel ran") {
  Rounds r;
  r.now_us = 20'000'000;
  r.sail(10, {kGlobal});
  r.now_us += 3'000'000;
  for (int k = 0; k < 10; ++k, r.now_us += kPeriod_us)
    r.hear(kOdometry, 1'000'000 + k * kPeriod_us);
  CHECK(r.sources.in_use() == kOdometry);
  CHECK(*r.sources.clock().offset_us() == doctest::Approx(23e6).epsilon(1e-4));
}

TEST_CASE("a source that repeats an old message is silent, and never comes back") {
  Rounds r;
  r.sail(10, {kGlobal, kFollow});
  const std::int64_t frozen_us = r.now_us - kPeriod_us;
  for (int k = 0; k < 50; ++k) {
    r.hear(kFollow, frozen_us);
    r.sail(1, {kGlobal});
    if (k > 6) REQUIRE(r.sources.in_use() == kGlobal);
  }
}

TEST_CASE("messages that arrive twice, over two radios, count like those that arrive once") {
  Rounds r;
  r.sail(10, {kGlobal});
  for (int k = 0; k < 6; ++k) {
    r.hear(kFollow, r.now_us);
    r.hear(kFollow, r.now_us - kPeriod_us);
    r.hear(kFollow, r.now_us);
    r.sail(1, {kGlobal});
  }
  CHECK(r.sources.in_use() == kFollow);
}

TEST_CASE("a local position without a known origin ranks below every global one") {
  Rounds r;
  r.origin_known = false;
  r.sail(10, {kOdometry});
  CHECK(r.sources.in_use() == kOdometry);  // better than nothing
  r.sail(10, {kOdometry, kGlobal});
  CHECK(r.sources.in_use() == kGlobal);
  r.origin_known = true;
  r.sail(10, {kOdometry, kGlobal});
  CHECK(r.sources.in_use() == kOdometry);
}

TEST_CASE("a source whose stamps went back while another was used reports a reboot, once") {
  Rounds r;
  r.sail(10, {kGlobal, kFollow});
  r.sail(10, {kGlobal});
  CHECK(r.sources.in_use() == kGlobal);
  r.hear(kFollow, 5);
  CHECK(r.sources.went_back(kFollow));
  r.sources.change_to(kFollow);
  CHECK_FALSE(r.sources.went_back(kFollow));
  CHECK_FALSE(r.sources.went_back(kGlobal));
}

TEST_CASE("one more in ODOMETRY's reset counter, in a new message, is an estimator reset") {
  Rounds r;
  CHECK_FALSE(r.sources.is_reset(1, r.now_us));
  r.sail(5, {kOdometry});
  r.sources.note_resets(255);
  CHECK_FALSE(r.sources.is_reset(255, r.now_us));
  CHECK_FALSE(r.sources.is_reset(1, r.now_us));  // perhaps another vessel's number
  CHECK(r.sources.is_reset(0, r.now_us));
  CHECK_FALSE(r.sources.is_reset(0, r.now_us - kPeriod_us));  // came late, over another radio
  r.sources.change_to(kGlobal);
  CHECK_FALSE(r.sources.is_reset(0, r.now_us));
}

}  // namespace
}  // namespace flotilla::app
