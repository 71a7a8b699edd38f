// SPDX-License-Identifier: MIT
#include "values.hpp"

#include <nanobind/stl/string.h>

#include <string>

namespace nb = nanobind;
using namespace flotilla;

namespace {

std::string number(float value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

}  // namespace

app::Parameters parameters_from(const nb::dict& values) {
  app::Parameters parameters;
  for (const auto& [key, value] : values) {
    std::string name;
    if (!nb::try_cast(key, name)) {
      throw nb::type_error("a parameter's name must be a string");
    }
    const app::ParameterInfo* info = app::find_parameter(name);
    if (info == nullptr) throw nb::value_error(("unknown parameter " + name).c_str());
    double desired = 0;
    const bool is_number = nb::try_cast(value, desired);
    if (!is_number || !app::is_valid(*info, static_cast<float>(desired))) {
      const std::string kind = info->whole() ? "a whole number" : "a number";
      const std::string unit = info->unit.empty() ? "" : std::string(" ").append(info->unit);
      throw nb::value_error((name + " = " + nb::cast<std::string>(nb::str(value)) +
                             " is out of range: " + kind + " from " + number(info->least) + " to " +
                             number(info->greatest) + unit +
                             (info->kind == app::ParameterKind::kSign ? ", not 0" : ""))
                                .c_str());
    }
    parameters.*(info->member) = static_cast<float>(desired);
  }
  if (const auto sentence = app::contradiction(parameters)) {
    throw nb::value_error(std::string(*sentence).c_str());
  }
  return parameters;
}

nb::dict pair(const char* a, double x, const char* b, double y) {
  nb::dict out;
  out[a] = x;
  out[b] = y;
  return out;
}

nb::dict triple(const char* a, double x, const char* b, double y, const char* c, double z) {
  nb::dict out = pair(a, x, b, y);
  out[c] = z;
  return out;
}
