// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <string>

#include "app/operator/telemetry/sentences.hpp"

namespace flotilla::app {
namespace {

std::string told(const Sentence& sentence) { return std::string(sentence.text()); }

TEST_CASE(
    "a slot that needs slightly more than the limit is reported with a figure above the limit") {
  CHECK(told(slot_needs(1.5001, " m/s, LAW_U_MAX is ", 1.5F)) ==
        "slot needs 1.51 m/s, LAW_U_MAX is 1.5");
}

TEST_CASE(
    "a boat out of its slot is reported with its distance, a spinning one with its yaw rate") {
  Parameters p;
  p.FS_SLOT_M = 5;
  p.LAW_R_MAX = 0.5F;
  CHECK(told(sentence_of(core::StationLoss::kLeft, 6.24, 2, p)) ==
        "boat left its slot: 6.2 m off, FS_SLOT_M is 5");
  CHECK(told(sentence_of(core::StationLoss::kStuck, 6.26, 2, p)) ==
        "boat does not approach its slot: 6.3 m off");
  CHECK(told(sentence_of(core::StationLoss::kSpins, 6.24, 0.612, p)) ==
        "boat spins: 0.61 rad/s, LAW_R_MAX is 0.5");
}

TEST_CASE("a weak propeller is reported with side, share, and time of day or duration") {
  constexpr std::int64_t kMinute_us = 60'000'000;
  const std::int64_t now = 40 * kMinute_us;                           // the boat's clock
  const std::int64_t morning = (20'000 * 24 + 10) * 60 * kMinute_us;  // 10:00 of some day
  const ModelMonitor::Finding port{ModelMonitor::Number::kBalance, 0.064F, now - 7 * kMinute_us};
  CHECK(told(sentence_of(port, 0, now, morning)) == "Port 12 % weak since 09:53: THR_BALANCE 0.06");
  CHECK(told(sentence_of(port, 0, now, 0)) == "Port 12 % weak for 7 min: THR_BALANCE 0.06");
  const ModelMonitor::Finding stbd{ModelMonitor::Number::kBalance, 0, now};
  CHECK(told(sentence_of(stbd, 0.064F, now, morning)) ==
        "Starboard 12 % weak since 10:00: THR_BALANCE 0");
  const ModelMonitor::Finding drag{ModelMonitor::Number::kDrag, 1.52F, now};
  CHECK(told(sentence_of(drag, 0, now, 0)) == "Drag 1.5 x VES_D11 for 1 min: identify the hull");
}

TEST_CASE("a voyage's steps are reported from 1, with their names") {
  using enum VoyageNews::Kind;
  const std::string count = std::to_string(kVoyageSteps.size());
  CHECK(told(sentence_of(VoyageNews{kBegins, 1, "drift"})) ==
        "Voyage: step 1 of " + count + ", drift");
  CHECK(told(sentence_of(VoyageNews{kAgain, 2, "too fast"})) == "Voyage: step 2 again: too fast");
  CHECK(told(sentence_of(VoyageNews{kLeftOut, 2, "too fast"})) ==
        "Voyage: step 2 skipped: too fast");
  CHECK(told(sentence_of(VoyageNews{kOver, 40, {}})) ==
        "Voyage: over, 40 of " + count + " steps complete");
}

TEST_CASE("links are numbered from 1, and the first closed one is reported") {
  CHECK(told(link_is_closed(0b110)) == "MAVLink link 1 is not open");
}

}  // namespace
}  // namespace flotilla::app
