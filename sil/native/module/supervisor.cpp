// SPDX-License-Identifier: MIT
#include "supervisor.hpp"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "app/operator/telemetry/text.hpp"
#include "snapshot.hpp"

namespace nb = nanobind;
using namespace flotilla;
using namespace nb::literals;

namespace {

constexpr std::array<const char*, core::kRequests> kRequestNames{
    "nothing", "disarm",    "arm",  "HOLD",   "MANUAL", "FORMATION",
    "test",    "terminate", "AUTO", "GUIDED", "LOITER", "RTL"};
constexpr std::array<const char*, core::kReactions> kReactionNames{"HOLD",  "LOITER", "RTL",
                                                                   "COAST", "MANUAL", "none"};
struct Choice {
  const char* parameter;
  core::Reaction core::Choices::* member;
};
constexpr std::array<Choice, 5> kChoices{{{"FS_LEADER_ACT", &core::Choices::leader},
                                          {"FS_GCS_ACT", &core::Choices::gcs},
                                          {"FS_BATT_ACT", &core::Choices::battery},
                                          {"FS_FENCE_ACT", &core::Choices::fence},
                                          {"FS_COAST_ACT", &core::Choices::coast_end}}};

nb::str text(std::string_view s) { return nb::str(s.data(), s.size()); }

nb::list names_of(core::Conditions set) {
  nb::list out;
  for (const auto& [bit, name] : kConditionNames) {
    if ((set & bit) != 0) out.append(name);
  }
  return out;
}

nb::list states_of(core::States set) {
  nb::list out;
  for (std::size_t i = 0; i < core::kStates; ++i) {
    const auto state = static_cast<core::State>(i);
    if ((set & core::in(state)) != 0) out.append(text(app::name_of(state)));
  }
  return out;
}

template <class Name>
std::size_t index_of(const std::string& name, std::size_t count, Name name_at) {
  for (std::size_t i = 0; i < count; ++i) {
    if (name == name_at(i)) return i;
  }
  throw nb::value_error(("no such thing: " + name).c_str());
}

core::State state_of(const std::string& name) {
  return static_cast<core::State>(index_of(name, core::kStates, [](std::size_t i) {
    return app::name_of(static_cast<core::State>(i));
  }));
}

/// Conditions that are met, and choices such as "FS_LEADER_ACT 1"; other choices are the defaults.
struct Told {
  core::Conditions met = 0;
  app::Parameters parameters{};
  core::Choices choices() const { return app::configuration_of(parameters).failsafes.choices; }
};

Told told_of(const std::vector<std::string>& names) {
  Told told;
  for (const std::string& name : names) {
    const std::size_t blank = name.find(' ');
    if (blank == name.npos) {
      told.met |= kConditionNames[index_of(name, kConditionNames.size(), [](std::size_t i) {
                    return kConditionNames[i].second;
                  })].first;
      continue;
    }
    const std::string parameter = name.substr(0, blank);
    index_of(parameter, kChoices.size(), [](std::size_t i) { return kChoices[i].parameter; });
    const app::ParameterInfo& info = *app::find_parameter(parameter);
    const float value = std::strtof(name.c_str() + blank, nullptr);
    if (!app::is_valid(info, value)) throw nb::value_error(("no such choice: " + name).c_str());
    told.parameters.*info.member = value;
  }
  return told;
}

nb::list table() {
  nb::list out;
  for (const core::Row& row : core::kTable) {
    nb::list on;
    for (std::size_t i = 0; i < core::kReactions; ++i) {
      if ((row.on & core::by(static_cast<core::Reaction>(i))) != 0) on.append(kReactionNames[i]);
    }
    nb::dict entry;
    entry["from"] = states_of(row.from);
    entry["request"] = kRequestNames[static_cast<std::size_t>(row.request)];
    entry["needs"] = names_of(row.needs);
    entry["lacks"] = names_of(row.lacks);
    entry["on"] = on;
    entry["to"] = text(app::name_of(row.to));
    out.append(entry);
  }
  return out;
}

nb::list losses() {
  nb::list out;
  for (const core::Loss& loss : core::kLossTable) {
    nb::dict entry;
    entry["in"] = states_of(loss.in);
    entry["needs"] = names_of(loss.needs);
    for (const Choice& choice : kChoices) {
      if (choice.member == loss.choice) entry["choice"] = choice.parameter;
    }
    out.append(entry);
  }
  return out;
}

nb::list choices() {
  nb::list out;
  for (const Choice& choice : kChoices) {
    const app::ParameterInfo& info = *app::find_parameter(choice.parameter);
    nb::list reactions;
    for (float value = info.least; value <= info.greatest; ++value) {
      app::Parameters parameters;
      parameters.*info.member = value;
      const auto chosen = app::configuration_of(parameters).failsafes.choices.*choice.member;
      reactions.append(kReactionNames[static_cast<std::size_t>(chosen)]);
    }
    nb::dict entry;
    entry["name"] = choice.parameter;
    entry["reactions"] = reactions;
    entry["default"] = static_cast<int>(info.default_value());
    out.append(entry);
  }
  return out;
}

/// The parameter that sets a condition's limit; empty if none does.
std::string_view limit_of(core::Conditions condition) {
  struct Limit {
    core::Conditions condition;
    std::string_view parameter;
  };
  constexpr std::array kLimits{
      Limit{core::kOwnFresh, "FS_NAV_S"},      Limit{core::kOwnTimed, "NAV_LAG_S"},
      Limit{core::kEscsOnline, "FS_ESC_S"},    Limit{core::kLeaderFresh, "FS_LEADER_S"},
      Limit{core::kLeaderTimed, "FORM_LAG_S"}, Limit{core::kLeaderNear, "FORM_DIST_MAX"},
      Limit{core::kOnStation, "FS_SLOT_M"},    Limit{core::kClear, "FS_SEP_M"},
      Limit{core::kInsideFence, "FS_FENCE_M"}, Limit{core::kBatteryGood, "FS_BATT_V"},
      Limit{core::kGcsHeard, "FS_GCS_S"},      Limit{core::kCoastRunning, "FS_COAST_S"},
  };
  const auto found = std::ranges::find(kLimits, condition, &Limit::condition);
  return found == kLimits.end() ? std::string_view() : found->parameter;
}

nb::list conditions() {
  nb::list out;
  for (const app::Complaint& complaint : app::kComplaints) {
    nb::dict entry;
    entry["name"] = names_of(complaint.condition)[0];
    entry["bit"] = std::countr_zero(complaint.condition);
    entry["complaint"] = text(complaint.sentence);
    entry["limit"] = text(limit_of(complaint.condition));
    out.append(entry);
  }
  return out;
}

nb::dict supervise(const std::string& state, const std::string& request,
                   const std::vector<std::string>& met) {
  const auto asked = static_cast<core::Request>(
      index_of(request, core::kRequests, [](std::size_t i) { return kRequestNames[i]; }));
  const Told told = told_of(met);
  const core::State from = state_of(state);
  const core::Verdict verdict =
      core::supervise(from, asked, told.met, core::response_to(told.choices(), from, told.met));
  nb::dict out;
  out["state"] = text(app::name_of(verdict.state));
  out["granted"] = verdict.granted;
  out["missing"] = names_of(verdict.missing);
  out["drives"] = core::may_drive(verdict.state, told.met);
  return out;
}

}  // namespace

void bind_supervisor(nb::module_& m) {
  m.def("supervisor_table", &table,
        "The supervisor's transitions in order: from, request, needs, lacks, on (reactions; empty: "
        "any), to.");
  m.def(
      "supervisor_losses", &losses,
      "The losses that the supervisor reacts to: in (states), needs (a loss if one of them is not "
      "met), choice (the parameter that sets the reaction). Of several reactions the most careful "
      "one counts: HOLD, LOITER, RTL, COAST, MANUAL.");
  m.def("supervisor_choices", &choices,
        "The operator's choices of reactions: name of the parameter, reactions by its value, "
        "default.");
  m.def(
      "supervisor_conditions", &conditions,
      "The supervisor's conditions, the most important first: name, bit (in NAMED_VALUE_FLOAT "
      "COND, from 24 on in COND2), complaint (the message if it is not met), limit (the parameter "
      "that sets it, or empty).");
  m.def(
      "supervise", &supervise, "state"_a, "request"_a, "met"_a,
      "Applies the table to a state and a request. met: names of the conditions that are met, and "
      "choices that differ from the defaults (\"FS_GCS_ACT 1\"). Returns state (the new one), "
      "granted (was the request?), missing (its unmet conditions), and drives: whether the "
      "propellers may turn in the new state. ValueError for an unknown name.");
}
