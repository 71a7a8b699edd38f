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
      // Keeps the GIL, so that no other thread touches the fleet or its arrays.
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
      "The rules that a Fleet checks for every boat in every tick: list of (group, name).");
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
      "The faults that a scenario can contain, as dictionaries. owner: the part that fails "
      "(\"world\": outside a Fleet, whose caller applies the fault); leaders: virtual leaders can "
      "have it too; unit, least, greatest: of its value, with an empty unit if it takes none; "
      "drawn: range from which a soak draws the value, None if it never draws the fault; name and "
      "meaning.");
  nb::class_<PyFleet>(
      m, "Fleet",
      "Simulates the devices and wires of many lockstep runs together: navigation units, boats "
      "with their ESCs, radio links, clocks. Agents (leaders and boats) and links are numbered "
      "from 0 in the order of adding. t_us is always the world's time, microseconds. scalar: "
      "number type of the boats' law, \"float\", \"double\" or \"q16\"; record, profile: enable "
      "take_records() and profile(); inject_failures: the boats obey MAV_CMD_INJECT_FAILURE, as in "
      "no other build. A bad argument raises a ValueError or TypeError that names it.")
      .def(nb::init<const std::string&, bool, bool, bool>(), "scalar"_a = "float",
           "record"_a = false, "profile"_a = false, "inject_failures"_a = false)
      .def("add_leader", &PyFleet::add_leader, "run"_a, "system"_a, "unit"_a, "clock"_a,
           "Adds a vehicle that is only a navigation unit to a run (0 or more), and returns its "
           "agent number. system: MAVLink system id, 1 to 255. unit: (rate_hz, message, "
           "attitude_rate_hz), optionally followed by (latitude degE7, longitude degE7, altitude "
           "mm), the origin of its frame, and by (delay_s, timesync, dropout_every_s, dropout_s), "
           "which sil.wire.navigation_unit.Settings explains. message: \"local\", \"odometry\", "
           "\"global\" or \"follow_target\"; attitude_rate_hz 0: ATTITUDE with every position. "
           "clock: (offset_us, drift_ppm).")
      .def("add_boat", &PyFleet::add_boat, "run"_a, "parameters"_a, "unit"_a, "clock"_a,
           "Adds a boat with two ESCs to a run, and returns its agent number. parameters: values "
           "by MAVLink name, the others keep their defaults; unit and clock: as in add_leader().")
      .def("connect", &PyFleet::connect, "sender"_a, "receiver"_a, "delay_s"_a = 0.0,
           "jitter_s"_a = 0.0, "loss"_a = 0.0, "rate_Bps"_a = 0.0, "seed"_a = 0,
           "Adds a one-way radio link between two agents, and returns its number. A sender's radio "
           "output goes over all its links. delay_s: delay; jitter_s: greatest random addition to "
           "it; loss: share of chunks lost, 0 to 1; rate_Bps: bytes per second, 0: unlimited; "
           "seed: of loss and jitter.")
      .def("set_link", &PyFleet::set_link, "link"_a, "delay_s"_a, "jitter_s"_a, "loss"_a,
           "rate_Bps"_a,
           "Changes a link's quality from now on, with arguments as in connect(). Chunks in flight "
           "arrive as they would have.")
      .def("corrupt", &PyFleet::corrupt, "link"_a, "offset_bit"_a,
           "Flips one bit of the next chunk sent over the link: number offset_bit, modulo the "
           "chunk's length in bits.")
      .def("tick", &PyFleet::tick, "t_us"_a, "eta"_a, "nu"_a, "degE7"_a.none(), "rpm"_a,
           "command"_a,
           "Runs one control tick of all agents. eta, nu: (agents, 3) float64, [x y psi] (m, rad) "
           "and [u v r] (m/s, rad/s) as each unit measures them, in the frame that it reports; "
           "degE7: (agents, 2) int32, latitude and longitude, None if no unit reports them; rpm: "
           "(boats, 2) float64, speeds of the port and starboard shafts, 1/min; command: (boats, "
           "2) float64, output: the ESCs' commands to the port and starboard motors, -1 to 1. All "
           "arrays are C-contiguous.")
      .def("hear", &PyFleet::hear, "agent"_a, "data"_a, "t_us"_a, "link"_a = 1,
           "Delivers bytes to a boat, in chunks of any length. link: 0 navigation unit, 1 radio.")
      .def("on_can", &PyFleet::on_can, "agent"_a, "can_id"_a, "data"_a, "t_us"_a,
           "Delivers a CAN frame from another node on a boat's bus, to its firmware and its ESCs.")
      .def("command", &PyFleet::command, "agents"_a, "t_us"_a, "command"_a, "params"_a,
           "Sends a COMMAND_LONG with up to 7 params (the others are 0) to each of these boats, by "
           "radio from their run's ground station (system 255, component 190).")
      .def("heartbeat", &PyFleet::heartbeat, "agents"_a, "t_us"_a,
           "Sends a HEARTBEAT to each of these boats, by radio from the same ground station as "
           "command().")
      .def("set_fault", &PyFleet::set_fault, "agent"_a, "kind"_a, "t_us"_a, "value"_a = 0.0,
           "esc"_a = nb::none(), "seed"_a = 0,
           "Starts a fault, which acts from the next tick on. kind: a name in "
           "flotilla.fault_list(), which gives the meaning, unit and range of value; esc: "
           "\"port\", \"stbd\" or None for both; seed: decides which data is lost or damaged.")
      .def("clear_fault", &PyFleet::clear_fault, "agent"_a, "kind"_a, "t_us"_a,
           "esc"_a = nb::none(), "Ends a fault; does nothing if the agent has none of this kind.")
      .def_prop_ro("states", &PyFleet::states,
                   "(boats,) uint8: state of each boat's supervisor after the last tick, as an "
                   "index into flotilla.STATES.")
      .def("sent", &PyFleet::sent, "agent"_a,
           "The bytes that the agent sent by radio in the last tick.")
      .def("snapshot", &PyFleet::snapshot, "agent"_a, "The boat's Boat.snapshot().")
      .def("parameters", &PyFleet::parameters, "agent"_a, "The boat's Boat.parameters().")
      .def("take_records", &PyFleet::take_records, "run"_a,
           "Returns the bytes and frames on the run's wires since the last call, in the format of "
           "sil/lockstep/recording.py. ValueError without record=True, or if the run has no "
           "agents.")
      .def("violations", &PyFleet::violations,
           "The first rule of flotilla.policies() that each boat has broken: list of (agent, t_us, "
           "name) in order of time.")
      .def("profile", &PyFleet::profile,
           "Returns the seconds spent in each stage since the last call: units, decode (of "
           "MAVLink), tick (of the boats), can, links. All are 0 without profile=True.");
}
