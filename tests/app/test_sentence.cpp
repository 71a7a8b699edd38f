// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cstdlib>
#include <string>

#include "app/parameters.hpp"
#include "app/sentence.hpp"

namespace flotilla::app {
namespace {

TEST_CASE("a sentence that is too long is cut off, not written beyond its end") {
  Sentence sentence;
  for (int i = 0; i < 50; ++i) sentence << "abc" << 1.5F;
  CHECK(sentence.text().size() == 120);
  CHECK(sentence.text().starts_with("abc1.5abc1.5"));
}

TEST_CASE("numbers in a sentence are written as usual, with six digits") {
  const auto written = [](float number) {
    Sentence sentence;
    sentence << number;
    return std::string(sentence.text());
  };
  for (const auto* text : {"0", "1", "-1", "0.1", "0.001", "3.436", "18.99", "254", "-1000",
                           "100000", "999999", "1e9", "-3e38", "-0.25", "nan", "inf", "-inf"}) {
    CHECK(written(std::strtof(text, nullptr)) == text);
  }
  for (const ParameterInfo& info : kParameterList) {
    for (const float value : {info.default_value(), info.least, info.greatest}) {
      CHECK(std::strtof(written(value).c_str(), nullptr) == value);
    }
  }
  CHECK(written(9.9999999F) == "10");
  CHECK(written(1e-12F) == "0");
}

}  // namespace
}  // namespace flotilla::app
