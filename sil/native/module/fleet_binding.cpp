// SPDX-License-Identifier: MIT
#include "fleet_binding.hpp"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cstdint>
#include <memory>
#include <string>
#include <variant>

#include "app/operator/telemetry/text.hpp"
#include "fleet/fleet.hpp"
#include "fleet_values.hpp"
#include "policies/rules.hpp"
#include "snapshot.hpp"
#include "values.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using namespace flotilla;
using namespace flotilla::fleet;

namespace {

nb::bytes bytes_of(std::span<const std::uint8_t> data) {
  return nb::bytes(data.data(), data.size());
}

std::span<const std::uint8_t> span_of(const nb::bytes& data) {
  return {static_cast<const std::uint8_t*>(data.data()), data.size()};
}

/// One Python type for fleets of any scalar.
class PyFleet {
  template <class Visitor>
  decltype(auto) visit(Visitor visitor) const {
    return std::visit([&](auto& fleet) -> decltype(auto) { return visitor(*fleet); }, fleet_);
  }

  static std::int64_t checked_run(std::int64_t run) {
    if (run < 0) refuse("run: from 0 up");
    return run;
  }

  static std::size_t agent(const auto& fleet, std::size_t agent) {
    if (agent >= fleet.agents()) {
      refuse("agent " + std::to_string(agent) + ": there are " + std::to_string(fleet.agents()));
    }
    return agent;
  }

  static std::size_t boat(const auto& fleet, std::size_t i) {
    const auto found = fleet.boat_of(agent(fleet, i));
    if (!found) refuse("agent " + std::to_string(i) + " is a leader, not a boat");
    return *found;
  }

  /// Checks that the agent can have the fault, and returns it.
  static std::size_t with(const auto& fleet, std::size_t i, const Fault& fault) {
    if (!row_of(fault.kind).leaders) boat(fleet, i);
    return agent(fleet, i);
  }

  static RadioLink& link_of(auto& fleet, std::size_t link) {
    if (link >= fleet.links()) {
      refuse("link " + std::to_string(link) + ": there are " + std::to_string(fleet.links()));
    }
    return fleet.link(link);
  }

 public:
  PyFleet(const std::string& scalar, bool record, bool profile, bool inject_failures) {
    if (scalar == "float") {
      fleet_.emplace<std::unique_ptr<Fleet<float>>>(
          new Fleet<float>(record, profile, inject_failures));
    } else if (scalar == "double") {
      fleet_.emplace<std::unique_ptr<Fleet<double>>>(
          new Fleet<double>(record, profile, inject_failures));
    } else if (scalar == "q16") {
      fleet_.emplace<std::unique_ptr<Fleet<core::Q16>>>(
          new Fleet<core::Q16>(record, profile, inject_failures));
    } else {
      refuse("scalar: \"float\", \"double\" or \"q16\", not \"" + scalar + "\"");
    }
  }

  std::size_t add_leader(std::int64_t run, int system, const nb::tuple& unit,
                         const nb::tuple& clock) {
    if (system < 1 || system > 255) refuse("system: from 1 to 255");
    const UnitSettings settings = unit_from(unit);
    const Clock own = clock_from(clock);
    return visit([&](auto& f) {
      return f.add_leader(checked_run(run), static_cast<std::uint8_t>(system), settings, own);
    });
  }

  std::size_t add_boat(std::int64_t run, const nb::dict& values, const nb::tuple& unit,
                       const nb::tuple& clock) {
    const app::Parameters parameters = parameters_from(values);
    const UnitSettings settings = unit_from(unit);
    const Clock own = clock_from(clock);
    return visit([&](auto& f) { return f.add_boat(checked_run(run), parameters, settings, own); });
  }

  std::size_t connect(std::size_t sender, std::size_t receiver, double delay_s, double jitter_s,
                      double loss, double rate_Bps, std::uint64_t seed) {
    const LinkQuality quality = quality_from(delay_s, jitter_s, loss, rate_Bps);
    return visit(
        [&](auto& f) { return f.connect(agent(f, sender), agent(f, receiver), quality, seed); });
  }

  void set_link(std::size_t link, double delay_s, double jitter_s, double loss, double rate_Bps) {
    const LinkQuality quality = quality_from(delay_s, jitter_s, loss, rate_Bps);
    visit([&](auto& f) { link_of(f, link).set(quality); });
  }

  void corrupt(std::size_t link, std::size_t bit) {
    visit([&](auto& f) { link_of(f, link).corrupt(bit); });
  }

  void tick(std::int64_t t_us, nb::handle eta, nb::handle nu, nb::handle degE7, nb::handle rpm,
            nb::handle command) {
    time_from(t_us);
    visit([&](auto& f) {
      const std::size_t agents = f.agents(), boats = f.boats();
      if (degE7.is_none() && f.tells_degrees()) {
        refuse("degE7: an int32 array of shape (" + std::to_string(agents) +
               ", 2): a unit tells where it is on the globe");
      }
      const Elements<const double> poses(eta, "eta", agents, 3), velocities(nu, "nu", agents, 3),
          shafts(rpm, "rpm", boats, 2);
      const Elements<double> motors(command, "command", boats, 2);
      std::optional<Elements<const std::int32_t>> places;
      if (!degE7.is_none()) places.emplace(degE7, "degE7", agents, 2);
      // Keeps the GIL, so that nobody else touches the fleet or its arrays meanwhile.
      f.tick(t_us, {poses.data(), velocities.data(), places ? places->data() : nullptr,
                    shafts.data(), motors.data()});
    });
  }

  void hear(std::size_t agent, const nb::bytes& data, std::int64_t t_us, std::size_t link) {
    if (link >= kLinks) refuse("link: 0 (navigation unit) or 1 (radio)");
    visit([&](auto& f) { f.hear(boat(f, agent), span_of(data), time_from(t_us), link); });
  }

  void on_can(std::size_t agent, std::uint32_t can_id, const nb::bytes& data, std::int64_t t_us) {
    visit([&](auto& f) { f.on_can(boat(f, agent), can_id, span_of(data), time_from(t_us)); });
  }

  void command(const std::vector<std::size_t>& agents, std::int64_t t_us, int command,
               const nb::sequence& params) {
    const Order order = order_from(command, params);
    visit([&](auto& f) {
      for (const std::size_t agent : agents) boat(f, agent);
      for (const std::size_t agent : agents) f.command(boat(f, agent), order, time_from(t_us));
    });
  }

  void heartbeat(const std::vector<std::size_t>& agents, std::int64_t t_us) {
    visit([&](auto& f) {
      for (const std::size_t agent : agents) boat(f, agent);
      for (const std::size_t agent : agents) f.heartbeat(boat(f, agent), time_from(t_us));
    });
  }

  void set_fault(std::size_t i, const std::string& kind, std::int64_t t_us, double value,
                 const nb::object& esc, std::uint64_t seed) {
    const Fault fault = fault_from(kind, value, esc, seed);
    visit([&](auto& f) { f.set_fault(with(f, i, fault), fault, time_from(t_us)); });
  }

  void clear_fault(std::size_t i, const std::string& kind, std::int64_t t_us,
                   const nb::object& esc) {
    const Fault fault = fault_from(kind, 0.0, esc, 0);
    visit([&](auto& f) { f.clear_fault(with(f, i, fault), fault, time_from(t_us)); });
  }

  nb::object states() const {
    return visit([](auto& f) {
      auto* states = new std::uint8_t[f.boats()];
      const nb::capsule owner(states,
                              [](void* p) noexcept { delete[] static_cast<std::uint8_t*>(p); });
      for (std::size_t i = 0; i < f.boats(); ++i) {
        states[i] = static_cast<std::uint8_t>(f.boat(i).state());
      }
      return nb::cast(nb::ndarray<nb::numpy, std::uint8_t>(states, {f.boats()}, owner));
    });
  }

  nb::bytes sent(std::size_t i) const {
    return visit([&](auto& f) { return bytes_of(f.sent(agent(f, i))); });
  }

  nb::dict snapshot(std::size_t agent) const {
    return visit([&](auto& f) { return snapshot_dict(f.boat(boat(f, agent)).snapshot()); });
  }

  nb::dict parameters(std::size_t agent) const {
    return visit([&](auto& f) { return parameters_dict(f.boat(boat(f, agent)).parameters()); });
  }

  nb::bytes take_records(std::int64_t run) {
    return visit([&](auto& f) {
      if (!f.records()) refuse("a fleet records nothing without record=True");
      Run* found = f.run(run);
      if (found == nullptr) refuse("run " + std::to_string(run) + ": it has no agent");
      return bytes_of(found->records.take());
    });
  }

  nb::list violations() const {
    return visit([](auto& f) {
      nb::list out;
      for (const auto& [agent, t_us, rule] : f.violations()) {
        out.append(nb::make_tuple(agent, t_us, nb::str(rule.data(), rule.size())));
      }
      return out;
    });
  }

  nb::dict profile() {
    constexpr std::array<const char*, kStages> kNames{"units", "decode", "tick", "can", "links"};
    const Seconds seconds = visit([](auto& f) { return f.take_profile(); });
    nb::dict out;
    for (std::size_t i = 0; i < kStages; ++i) out[kNames[i]] = seconds[i];
    return out;
  }

 private:
  std::variant<std::unique_ptr<Fleet<float>>, std::unique_ptr<Fleet<double>>,
               std::unique_ptr<Fleet<core::Q16>>>
      fleet_;
};

}  // namespace

void bind_fleet(nb::module_& m) {
  nb::list states;
  for (std::size_t i = 0; i < core::kStates; ++i) {
    const auto name = app::name_of(static_cast<core::State>(i));
    states.append(nb::str(name.data(), name.size()));
  }
  m.attr("STATES") = nb::tuple(states);
  m.def(
      "policies",
      [] {
        nb::list out;
        for (const auto& [group, name, holds] : policies::kRules) {
          out.append(nb::make_tuple(nb::str(group.data(), group.size()),
                                    nb::str(name.data(), name.size())));
        }
        return out;
      },
      "The rules that every boat of a Fleet is watched by in every tick: (group, name).");
  m.def(
      "fault_list",
      [] {
        const auto text = [](std::string_view words) {
          return nb::str(words.data(), words.size());
        };
        nb::list out;
        for (const FaultRow& row : kFaults) {
          nb::dict fault;
          fault["name"] = text(row.name);
          fault["owner"] = text(kOwnerNames[static_cast<std::size_t>(row.owner)]);
          fault["leaders"] = row.leaders;
          fault["unit"] = text(row.unit);
          fault["least"] = row.allowed.least;
          fault["greatest"] = row.allowed.greatest;
          fault["drawn"] = nb::none();
          if (row.drawn) fault["drawn"] = nb::make_tuple(row.drawn->least, row.drawn->greatest);
          fault["meaning"] = text(row.meaning);
          out.append(fault);
        }
        return out;
      },
      "The faults of a scenario: name; owner, the part that fails (\"world\": not on a fleet's "
      "wires); leaders: virtual leaders can have it too; unit, least and greatest of its value, no "
      "unit where it takes none; drawn: the range that a soak draws from, if it does; meaning.");
  nb::class_<PyFleet>(
      m, "Fleet",
      "Everything that is on a wire in lockstep runs, many at once: navigation units, boats with "
      "their ESCs, radio links, clocks. Agents (leaders and boats) and links are counted from 0 in "
      "order of adding; times are the world's, microseconds. scalar of the boats' law: \"float\", "
      "\"double\" or \"q16\". inject_failures: boats obey MAV_CMD_INJECT_FAILURE, which no other "
      "build "
      "does. Bad values: ValueError or TypeError says which.")
      .def(nb::init<const std::string&, bool, bool, bool>(), "scalar"_a = "float",
           "record"_a = false, "profile"_a = false, "inject_failures"_a = false)
      .def("add_leader", &PyFleet::add_leader, "run"_a, "system"_a, "unit"_a, "clock"_a,
           "A vehicle that is only a navigation unit; its agent number. unit: (rate_hz, message, "
           "attitude_rate_hz) and, where wanted, (latitude degE7, longitude degE7, altitude mm) "
           "of its frame and (delay_s, timesync, dropout_every_s, dropout_s), as "
           "sil.wire.navigation_unit.Settings explains them; message: \"local\", \"odometry\", "
           "\"global\" or \"follow_target\"; "
           "attitude_rate_hz 0: with every position. clock: (offset_us, drift_ppm).")
      .def("add_boat", &PyFleet::add_boat, "run"_a, "parameters"_a, "unit"_a, "clock"_a,
           "A boat with parameters by name, a navigation unit as add_leader's and two ESCs; its "
           "agent number.")
      .def("connect", &PyFleet::connect, "sender"_a, "receiver"_a, "delay_s"_a = 0.0,
           "jitter_s"_a = 0.0, "loss"_a = 0.0, "rate_Bps"_a = 0.0, "seed"_a = 0,
           "A one-way radio link; its number. What the sender says over the radio goes over all "
           "its links.")
      .def("set_link", &PyFleet::set_link, "link"_a, "delay_s"_a, "jitter_s"_a, "loss"_a,
           "rate_Bps"_a, "Its quality from now on; chunks in flight arrive as they would have.")
      .def("corrupt", &PyFleet::corrupt, "link"_a, "offset_bit"_a,
           "Flips that bit, counted modulo its length, of the next chunk sent over the link.")
      .def("tick", &PyFleet::tick, "t_us"_a, "eta"_a, "nu"_a, "degE7"_a.none(), "rpm"_a,
           "command"_a,
           "One control tick of all. eta, nu: (agents, 3) float64, [x y psi] and [u v r] as each "
           "unit measured them, in the frame that it tells; degE7: (agents, 2) int32, latitude and "
           "longitude, None where no unit tells them; rpm: (boats, 2) float64 of the shafts, port, "
           "starboard; command: (boats, 2) float64, written: what the ESCs tell their motors, -1 "
           "to 1.")
      .def("hear", &PyFleet::hear, "agent"_a, "data"_a, "t_us"_a, "link"_a = 1,
           "Any bytes into a boat's link: 0 navigation unit, 1 radio.")
      .def("on_can", &PyFleet::on_can, "agent"_a, "can_id"_a, "data"_a, "t_us"_a,
           "A frame on a boat's CAN bus, as from another node: its firmware and its ESCs hear it.")
      .def("command", &PyFleet::command, "agents"_a, "t_us"_a, "command"_a, "params"_a,
           "COMMAND_LONG with up to 7 params over the radio to each of these boats, from their "
           "run's ground station (255/190).")
      .def("heartbeat", &PyFleet::heartbeat, "agents"_a, "t_us"_a,
           "HEARTBEAT of that ground station, over the radio to each of these boats.")
      .def("set_fault", &PyFleet::set_fault, "agent"_a, "kind"_a, "t_us"_a, "value"_a = 0.0,
           "esc"_a = nb::none(), "seed"_a = 0,
           "Something goes wrong from the next tick on. kind: a name of flotilla.fault_list(), "
           "which has "
           "the meaning and unit of value; esc: \"port\", \"stbd\" or None for both; seed: decides "
           "what is lost or damaged.")
      .def("clear_fault", &PyFleet::clear_fault, "agent"_a, "kind"_a, "t_us"_a,
           "esc"_a = nb::none(), "It is over; nothing happens where there is none.")
      .def_prop_ro("states", &PyFleet::states,
                   "(boats,) uint8: the supervisors' states after the last tick, as numbers in "
                   "flotilla.STATES.")
      .def("sent", &PyFleet::sent, "agent"_a,
           "The bytes that it sent over the radio in the last tick.")
      .def("snapshot", &PyFleet::snapshot, "agent"_a, "As Boat.snapshot.")
      .def("parameters", &PyFleet::parameters, "agent"_a, "As Boat.parameters.")
      .def("take_records", &PyFleet::take_records, "run"_a,
           "The bytes and frames on the run's wires since the last call, in the format of "
           "sil/lockstep/recording.py; needs record=True.")
      .def("violations", &PyFleet::violations,
           "The first rule of flotilla.policies() that each boat has broken, in the order of time: "
           "(agent, t_us, name).")
      .def("profile", &PyFleet::profile,
           "Seconds by stage since the last call: units, decode (of MAVLink), tick (of the boats), "
           "can, links; zeros without profile=True.");
}
