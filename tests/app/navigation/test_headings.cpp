// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "app/navigation/headings.hpp"

namespace flotilla::app {
namespace {

using Verdict = Headings<double>::Verdict;

convert::HeadingSample<double> at(std::int64_t stamp_us) { return {stamp_us, 0.5, 0}; }

TEST_CASE(
    "headings are kept for the component in use and one other; a switch to it keeps its heading") {
  Headings<double> headings;
  CHECK(headings.of(1, true) == nullptr);
  CHECK(headings.take(at(100'000), 1, true, false, 100'000) == Verdict::kTaken);
  CHECK(headings.take(at(5), 2, false, false, 100'000) == Verdict::kTaken);
  REQUIRE(headings.of(1, true) != nullptr);
  CHECK(headings.of(1, true)->sample.stamp_us == 100'000);
  CHECK(headings.of(2, true) == nullptr);
  REQUIRE(headings.of(2, false) != nullptr);
  headings.use(*headings.of(2, false));
  REQUIRE(headings.of(2, true) != nullptr);
  CHECK(headings.of(2, true)->sample.stamp_us == 5);
  CHECK(headings.take(at(6), 3, false, false, 200'000) == Verdict::kTaken);
  CHECK(headings.of(2, false) == nullptr);
}

TEST_CASE("an old heading is late unless its vessel is silent; one far ahead is rejected") {
  Headings<double> headings;
  headings.take(at(100'000), 1, true, false, 100'000);
  CHECK(headings.take(at(100'000), 1, true, false, 200'000) == Verdict::kLate);
  CHECK(headings.take(at(100'000), 1, true, true, 200'000) == Verdict::kTaken);
  CHECK(headings.take(at(1'200'001), 1, true, false, 300'000) == Verdict::kLeapt);
  CHECK(headings.take(at(1'200'000), 1, true, false, 300'000) == Verdict::kTaken);
  CHECK(headings.take(at(9'000'000), 1, true, false, 600'000) == Verdict::kTaken);
}

TEST_CASE("headings continue when the 32-bit clock wraps") {
  constexpr std::int64_t kTurn_us = (std::int64_t{1} << 32) * 1000;
  Headings<double> headings;
  headings.take(at(kTurn_us - 50'000), 1, true, false, 100'000);
  CHECK(headings.take(at(50'000), 1, true, false, 200'000) == Verdict::kTaken);
  CHECK(headings.of(1, true)->sample.stamp_us == kTurn_us + 50'000);
}

}  // namespace
}  // namespace flotilla::app
