// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <set>
#include <string>
#include <vector>

#include "app/operator/telemetry/text.hpp"

namespace flotilla::app {
namespace {

std::vector<std::string> complaints_of(core::Conditions unmet) {
  std::vector<std::string> said;
  for_each_complaint(unmet, [&](std::string_view why) { said.emplace_back(why); });
  return said;
}

TEST_CASE("every state has its own name") {
  using core::State;
  CHECK(name_of(State::kDisarmed) == "DISARMED");
  CHECK(name_of(State::kHold) == "HOLD");
  CHECK(name_of(State::kManual) == "MANUAL");
  CHECK(name_of(State::kFormation) == "FORMATION");
  CHECK(name_of(State::kCoast) == "COAST");
  CHECK(name_of(State::kTest) == "TEST");
  CHECK(name_of(State::kFault) == "FAULT");
}

TEST_CASE("every unmet condition has its own sentence, which fits into a STATUSTEXT") {
  std::set<std::string> said;
  for (unsigned bit = 0; bit < core::kConditionCount; ++bit) {
    const auto unmet = core::Conditions{1} << bit;
    const auto sentences = complaints_of(unmet);
    CAPTURE(bit);
    REQUIRE(sentences.size() == 1);
    CHECK(complaint_of(unmet) == sentences[0]);
    CHECK(std::string("Refused: ").size() + sentences[0].size() <= 50);
    CHECK(std::string("FORMATION: ").size() + sentences[0].size() <= 50);
    said.insert(sentences[0]);
  }
  CHECK(said.size() == core::kConditionCount);
  CHECK(said.count("no MANUAL_CONTROL or RC input") == 1);
  CHECK(said.count("no motor test is running") == 1);
}

TEST_CASE("several unmet conditions are reported one by one, the most important first") {
  const auto said =
      complaints_of(core::kTestRunning | core::kOwnFresh | core::kEscsOnline | core::kBusUp);
  CHECK(said == std::vector<std::string>{"CAN bus is down", "no recent navigation data",
                                         "an ESC is offline or reports a fault",
                                         "no motor test is running"});
  for (unsigned one = 0; one < core::kConditionCount; ++one) {
    for (unsigned other = 0; other < core::kConditionCount; ++other) {
      const auto set = core::Conditions{1} << one | core::Conditions{1} << other;
      CHECK(complaint_of(set) == complaints_of(set).at(0));
    }
  }
  CHECK(complaints_of(core::kAllConditions).size() == core::kConditionCount);
  CHECK(complaints_of(0).empty());
  CHECK(complaint_of(0).empty());
}

}  // namespace
}  // namespace flotilla::app
