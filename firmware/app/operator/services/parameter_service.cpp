// SPDX-License-Identifier: MIT
#include "app/operator/services/parameter_service.hpp"

#include <algorithm>

#include "app/parameters/configuration.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;

constexpr int kTurns = 3;

link::Text<16> wire_name(std::string_view name) {
  link::Text<16> text{};
  std::copy_n(name.begin(), std::min(name.size(), text.size()), text.begin());
  return text;
}

/// A name of 16 characters has no NUL.
std::string_view name_in(const link::Text<16>& text) {
  const auto end = std::ranges::find(text, '\0');
  return {text.data(), static_cast<std::size_t>(end - text.begin())};
}

std::size_t index_of(const ParameterInfo& info) {
  return static_cast<std::size_t>(&info - kParameterList.data());
}

link::ParamValue value_message(std::size_t index, const Parameters& values) {
  const ParameterInfo& info = kParameterList[index];
  return {values.*info.member, static_cast<std::uint16_t>(kParameterList.size()),
          static_cast<std::uint16_t>(index), wire_name(info.name), mav::kParamReal32};
}

void append_allowed(const ParameterInfo& info, Sentence& sentence) {
  switch (info.kind) {
    case ParameterKind::kSign:
      sentence << "-1 or 1";
      return;
    case ParameterKind::kWhole:
    case ParameterKind::kIdentity:
    case ParameterKind::kAutopilot:
    case ParameterKind::kFrame:
    case ParameterKind::kSwitch:
    case ParameterKind::kAction:
    case ParameterKind::kStop:
      sentence << "whole numbers, ";
      break;
    case ParameterKind::kReal:
      break;
  }
  sentence << info.least << " to " << info.greatest;
  if (!info.unit.empty()) sentence << " " << info.unit;
}

SetResult refusal(const ParameterInfo& info, std::uint8_t error, float value) {
  SetResult result{SetResult::Outcome::kRefused, &info, error};
  result.sentence << info.name << " " << value << " refused: ";
  return result;
}

SetResult refusal(const ParameterInfo& info, std::uint8_t error, float value,
                  std::string_view why) {
  SetResult result = refusal(info, error, value);
  result.sentence << why;
  return result;
}

bool is_stranger(link::Address from, const Parameters& values) {
  return configuration_of(values).operators.commander.value_or(from.system) != from.system;
}

/// Decides about the set; changes nothing.
SetResult judge(const ParameterInfo& info, link::Address from, const link::ParamSet& asked,
                const Parameters& values, Standing boat) {
  const float value = asked.param_value;
  if (is_stranger(from, values)) {
    return refusal(info, mav::kParamPermissionDenied, value, "only MAV_GCS_SYSID may set it");
  }
  if (asked.param_type != mav::kParamReal32) {
    return refusal(info, mav::kParamTypeMismatch, value, "its type is REAL32");
  }
  if (!is_valid(info, value)) {
    SetResult result = refusal(info, mav::kParamOutOfRange, value);
    append_allowed(info, result.sentence);
    return result;
  }
  // Allowed while armed: a client's retransmission changes nothing.
  if (value == values.*info.member) return {SetResult::Outcome::kUnchanged, &info};
  if (boat.armed && info.change != ParameterChange::kAnytime) {
    return refusal(info, mav::kParamPermissionDenied, value, "only while disarmed");
  }
  if (info.member == &Parameters::FORM_LEADER && value == static_cast<float>(boat.system)) {
    return refusal(info, mav::kParamOutOfRange, value, "it is this boat's own system id");
  }
  Parameters desired = values;
  desired.*info.member = value;
  if (const auto why = contradiction(desired)) {
    return refusal(info, mav::kParamOutOfRange, value, *why);
  }
  return {SetResult::Outcome::kSet, &info};
}

}  // namespace

bool ParameterService::Errors::push(const link::ParamError& error) {
  if (count == ring.size()) return false;
  ring[(first + count++) % ring.size()] = error;
  return true;
}

std::optional<link::ParamError> ParameterService::Errors::pop() {
  if (count == 0) return std::nullopt;
  const link::ParamError error = ring[first];
  first = (first + 1) % ring.size();
  --count;
  return error;
}

std::optional<std::size_t> ParameterService::Owed::take_single() {
  if (values.none()) return std::nullopt;
  while (!values[next_value]) next_value = (next_value + 1) % kCount;
  const std::size_t index = next_value;
  next_value = (next_value + 1) % kCount;
  return index;
}

std::optional<std::size_t> ParameterService::Owed::take_of_list() {
  if (list_at == kCount) return std::nullopt;
  return list_at++;
}

bool ParameterService::knows(const link::ParamSet& asked) {
  return find_parameter(name_in(asked.param_id)) != nullptr;
}

void ParameterService::list(std::size_t link) { links_[link].list_at = 0; }

void ParameterService::read(std::size_t link, link::Address from,
                            const link::ParamRequestRead& asked) {
  Owed& owed = links_[link];
  if (asked.param_index == -1) {
    if (const ParameterInfo* info = find_parameter(name_in(asked.param_id))) {
      owed.values.set(index_of(*info));
      return;
    }
  } else if (asked.param_index >= 0 && static_cast<std::size_t>(asked.param_index) < kCount) {
    owed.values.set(static_cast<std::size_t>(asked.param_index));
    return;
  }
  owed.errors.push({asked.param_index, from, asked.param_id, mav::kParamDoesNotExist});
}

SetResult ParameterService::set(std::size_t link, link::Address from, const link::ParamSet& asked,
                                Parameters& values, Standing boat) {
  const ParameterInfo* info = find_parameter(name_in(asked.param_id));
  if (info == nullptr) {
    links_[link].errors.push({-1, from, asked.param_id, mav::kParamDoesNotExist});
    SetResult result{SetResult::Outcome::kRefused, nullptr, mav::kParamDoesNotExist};
    result.sentence << name_in(asked.param_id) << " is an unknown parameter";
    return result;
  }
  SetResult result = judge(*info, from, asked, values, boat);
  switch (result.outcome) {
    case SetResult::Outcome::kSet:
      values.*info->member = asked.param_value;
      [[fallthrough]];
    case SetResult::Outcome::kUnchanged:
      announce(*info);
      break;
    case SetResult::Outcome::kRefused:
      refuse(link, from, *info, result.error);
      break;
  }
  return result;
}

void ParameterService::announce(const ParameterInfo& info) {
  for (Owed& owed : links_) owed.values.set(index_of(info));
}

void ParameterService::refuse(std::size_t link, link::Address to, const ParameterInfo& info,
                              std::uint8_t error) {
  announce(info);
  const std::size_t index = index_of(info);
  // Send the error first: a MAVSDK client that gets the value first repeats its request.
  if (links_[link].errors.push(
          {static_cast<std::int16_t>(index), to, wire_name(info.name), error})) {
    links_[link].values.reset(index);
  }
}

bool ParameterService::owes(std::size_t link) const {
  const Owed& owed = links_[link];
  return owed.refused || owed.errors.count > 0 || owed.values.any() || owed.list_at < kCount;
}

std::optional<link::Message> ParameterService::next(std::size_t link, const Parameters& values) {
  Owed& owed = links_[link];
  if (owed.refused) {
    const std::size_t index = *owed.refused;
    owed.refused.reset();
    owed.values.reset(index);
    return value_message(index, values);
  }
  for (int i = 0; i < kTurns; ++i) {
    if (auto message = take_turn(owed, values)) return message;
  }
  return std::nullopt;
}

std::optional<link::Message> ParameterService::take_turn(Owed& owed, const Parameters& values) {
  const int turn = owed.turn;
  owed.turn = (owed.turn + 1) % kTurns;
  if (turn == 0) {
    const auto error = owed.errors.pop();
    if (!error) return std::nullopt;
    // For an existing parameter, its present value follows at once.
    const auto index = static_cast<std::size_t>(error->param_index);
    if (error->param_index >= 0 && index < kCount) owed.refused = index;
    return *error;
  }
  const auto index = turn == 1 ? owed.take_single() : owed.take_of_list();
  if (!index) return std::nullopt;
  owed.values.reset(*index);  // one answer serves all clients that asked
  return value_message(*index, values);
}

}  // namespace flotilla::app
