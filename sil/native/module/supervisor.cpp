// SPDX-License-Identifier: MIT
#include "supervisor.hpp"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <bit>
#include <string>
#include <vector>

#include "app/operator/text.hpp"
#include "snapshot.hpp"

namespace nb = nanobind;
using namespace flotilla;
using namespace nb::literals;

namespace {

constexpr std::array<const char*, core::kRequests> kRequestNames{
    "nothing", "disarm", "arm", "HOLD", "MANUAL", "FORMATION", "test", "terminate", "AUTO"};
constexpr std::array<std::pair<core::Conditions, const char*>, 4> kChoices{
    {{core::kLeaderLossHolds, "FS_LEADER_ACT 0"},
     {core::kLeaderLossCoasts, "FS_LEADER_ACT 1"},
     {core::kGcsLossHolds, "FS_GCS_ACT 0"},
     {core::kGcsLossCoasts, "FS_GCS_ACT 1"}}};

nb::str text(std::string_view s) { return nb::str(s.data(), s.size()); }

nb::list names_of(core::Conditions set) {
  nb::list out;
  for (const auto& [bit, name] : kChoices) {
    if ((set & bit) != 0) out.append(name);
  }
  for (const auto& [bit, name] : kConditionNames) {
    if ((set & bit) != 0) out.append(name);
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

core::Conditions set_of(const std::vector<std::string>& names) {
  core::Conditions set = 0;
  for (const std::string& name : names) {
    const std::size_t i = index_of(name, kConditionNames.size() + kChoices.size(), [](auto at) {
      return at < kChoices.size() ? kChoices[at].second
                                  : kConditionNames[at - kChoices.size()].second;
    });
    set |= i < kChoices.size() ? kChoices[i].first : kConditionNames[i - kChoices.size()].first;
  }
  return set;
}

nb::list table() {
  nb::list out;
  for (const core::Row& row : core::kTable) {
    nb::list from;
    for (std::size_t i = 0; i < core::kStates; ++i) {
      const auto state = static_cast<core::State>(i);
      if ((row.from & core::in(state)) != 0) from.append(text(app::name_of(state)));
    }
    nb::dict entry;
    entry["from"] = from;
    entry["request"] = kRequestNames[static_cast<std::size_t>(row.request)];
    entry["needs"] = names_of(row.needs);
    entry["lacks"] = names_of(row.lacks);
    entry["to"] = text(app::name_of(row.to));
    out.append(entry);
  }
  return out;
}

nb::list conditions() {
  nb::list out;
  for (const app::Complaint& complaint : app::kComplaints) {
    nb::dict entry;
    entry["name"] = names_of(complaint.condition)[0];
    entry["bit"] = std::countr_zero(complaint.condition);
    entry["complaint"] = text(complaint.sentence);
    entry["limit"] = text(complaint.limit);
    out.append(entry);
  }
  return out;
}

nb::dict supervise(const std::string& state, const std::string& request,
                   const std::vector<std::string>& met) {
  const auto asked = static_cast<core::Request>(
      index_of(request, core::kRequests, [](std::size_t i) { return kRequestNames[i]; }));
  const core::Verdict verdict = core::supervise(state_of(state), asked, set_of(met));
  nb::dict out;
  out["state"] = text(app::name_of(verdict.state));
  out["granted"] = verdict.granted;
  out["missing"] = names_of(verdict.missing);
  out["drives"] = core::may_drive(verdict.state, set_of(met));
  return out;
}

}  // namespace

void bind_supervisor(nb::module_& m) {
  m.def("supervisor_table", &table,
        "The supervisor's transitions in order: from, request, needs, lacks, to.");
  m.def(
      "supervisor_conditions", &conditions,
      "Its conditions, the most important first: name, bit (in NAMED_VALUE_FLOAT COND, from 24 on "
      "in COND2), complaint "
      "(what the boat says where it is not met), limit (the parameter that sets it, or nothing).");
  m.def("supervise", &supervise, "state"_a, "request"_a, "met"_a,
        "What the table makes of a state, a request and the names of what is met or chosen: state, "
        "granted, missing, and drives, whether propellers may turn there. ValueError for a name "
        "that there is not.");
}
