// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>
#include <set>
#include <string>

#include "app/parameters.hpp"

namespace flotilla::app {
namespace {

TEST_CASE("every parameter has a wire name, a range that holds its default, and a sentence") {
  std::set<std::string_view> names;
  for (const ParameterInfo& info : kParameterList) {
    CAPTURE(std::string(info.name));
    CHECK(info.name.size() <= 16);
    CHECK(names.insert(info.name).second);
    CHECK(info.least < info.greatest);
    CHECK(is_valid(info, info.default_value()));
    CHECK(kParameterTexts[names.size() - 1].sentence.ends_with('.'));
    CHECK(find_parameter(info.name) == &info);
  }
  CHECK(find_parameter("NO_SUCH_NAME") == nullptr);
  CHECK(find_parameter("LAW_K") == nullptr);
  CHECK(find_parameter("") == nullptr);
}

TEST_CASE("NaN, out-of-range values, and fractions where a whole number is needed, are refused") {
  for (const ParameterInfo& info : kParameterList) {
    CAPTURE(std::string(info.name));
    for (const float bad : {NAN, INFINITY, -INFINITY}) CHECK_FALSE(is_valid(info, bad));
    CHECK(is_valid(info, info.least));
    CHECK(is_valid(info, info.greatest));
    CHECK_FALSE(is_valid(info, std::nextafter(info.least, -1e9F)));
    CHECK_FALSE(is_valid(info, std::nextafter(info.greatest, 1e9F)));
    if (info.whole()) CHECK_FALSE(is_valid(info, info.least + 0.5F));
  }
  CHECK_FALSE(is_valid(*find_parameter("THR_PORT_DIR"), 0));
  CHECK_FALSE(is_valid(*find_parameter("CTL_RATE"), 49));
}

TEST_CASE("one ESC for both propellers, or a boat that follows itself, is a contradiction") {
  Parameters p;
  CHECK_FALSE(contradiction(p));
  p.ESC_STBD = p.ESC_PORT;
  CHECK(contradiction(p)->find("ESC_PORT") != std::string_view::npos);
  p = {};
  p.FORM_LEADER = p.MAV_SYSID;
  CHECK(contradiction(p)->find("FORM_LEADER") != std::string_view::npos);
}

}  // namespace
}  // namespace flotilla::app
