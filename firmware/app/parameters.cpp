// SPDX-License-Identifier: MIT
#include "app/parameters.hpp"

#include <cmath>

namespace flotilla::app {

const ParameterInfo* find_parameter(std::string_view name) {
  for (const ParameterInfo& info : kParameterList) {
    if (info.name == name) return &info;
  }
  return nullptr;
}

bool is_valid(const ParameterInfo& info, float value) {
  if (!std::isfinite(value) || value < info.least || value > info.greatest) return false;
  switch (info.kind) {
    case ParameterKind::kReal:
      return true;
    case ParameterKind::kWhole:
    case ParameterKind::kIdentity:
    case ParameterKind::kAutopilot:
    case ParameterKind::kFrame:
    case ParameterKind::kSwitch:
    case ParameterKind::kAction:
    case ParameterKind::kStop:
      return static_cast<float>(static_cast<std::int64_t>(value)) == value;
    case ParameterKind::kSign:
      return std::abs(value) == 1.0F;
  }
  return false;
}

std::optional<std::string_view> contradiction(const Parameters& p) {
  if (p.ESC_PORT == p.ESC_STBD) return "ESC_PORT and ESC_STBD are the same ESC";
  const float weaker = 1 - std::abs(p.THR_BALANCE);
  if (p.THR_DEAD >= weaker * p.THR_FWD_MAX || p.THR_DEAD >= weaker * p.THR_REV_MAX) {
    return "THR_DEAD is not below THR_FWD_MAX and THR_REV_MAX";
  }
  if (p.MAV_IDENTITY == 1.0F && p.MAV_COMPID == 1.0F) {
    return "companion (MAV_IDENTITY 1): set MAV_COMPID 191";
  }
  if (p.FORM_LEADER == p.MAV_SYSID) return "FORM_LEADER is this boat's own MAV_SYSID";
  return std::nullopt;
}

}  // namespace flotilla::app
