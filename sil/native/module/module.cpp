// SPDX-License-Identifier: MIT
// The native module `flotilla`: the boat's firmware for the SIL, tests and notebooks.
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <array>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "app/boat/boat.hpp"
#include "app/operator/services/metadata.hpp"
#include "app/operator/telemetry/text.hpp"
#include "app/parameters/derived.hpp"
#include "app/version.hpp"
#include "fleet_binding.hpp"
#include "helm.hpp"
#include "plant/plant.hpp"
#include "route.hpp"
#include "snapshot.hpp"
#include "supervisor.hpp"
#include "traces.hpp"
#include "values.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using namespace flotilla;

namespace {

struct TickOutput {
  nb::list mavlink;
  nb::list can;
};

nb::bytes bytes_of(std::span<const std::uint8_t> data) {
  return nb::bytes(data.data(), data.size());
}

std::span<const std::uint8_t> span_of(const nb::bytes& data) {
  return {static_cast<const std::uint8_t*>(data.data()), data.size()};
}

/// One Python type for boats of any scalar.
class PyBoat {
 public:
  PyBoat(const nb::dict& values, int links, const std::string& scalar)
      : links_(static_cast<std::size_t>(links)) {
    if (links < 1 || links_ > app::kMaxLinks)
      throw nb::value_error("links: a whole number from 1 to 4");
    const app::Parameters parameters = parameters_from(values);
    if (scalar == "float") {
      boat_ = std::make_unique<app::Boat<float>>(parameters, links_);
    } else if (scalar == "double") {
      boat_ = std::make_unique<app::Boat<double>>(parameters, links_);
    } else if (scalar == "q16") {
      boat_ = std::make_unique<app::Boat<core::Q16>>(parameters, links_);
    } else {
      throw nb::value_error(
          ("scalar: \"float\", \"double\" or \"q16\", not \"" + scalar + "\"").c_str());
    }
  }

  void on_mavlink(const nb::bytes& data, std::int64_t now_us, int link) {
    if (link < 0 || static_cast<std::size_t>(link) >= links_) {
      throw nb::value_error(("link: from 0 to " + std::to_string(links_ - 1)).c_str());
    }
    const auto bytes = span_of(data);
    std::visit([&](auto& b) { b->on_mavlink(bytes, now_us, static_cast<std::size_t>(link)); },
               boat_);
  }

  void on_can(std::uint32_t can_id, const nb::bytes& data, std::int64_t now_us) {
    const auto bytes = span_of(data);
    std::visit([&](auto& b) { b->on_can(can_id, bytes, now_us); }, boat_);
  }

  void keep_logs(const nb::list& logs) {
    logs_.clear();
    for (const nb::handle log : logs) {
      const auto bytes = span_of(nb::cast<nb::bytes>(log));
      logs_.emplace_back(bytes.begin(), bytes.end());
    }
    std::visit([](auto& b) { b->logs().open(); }, boat_);
  }

  TickOutput tick(std::int64_t now_us) {
    std::visit([&](auto& b) { bring_logs(b->logs()); }, boat_);
    TickOutput out;
    std::visit(
        [&](auto& b) {
          const auto sent = b->tick(now_us);
          for (std::size_t link = 0; link < links_; ++link) {
            const auto bytes = sent.links->bytes(link);
            if (!bytes.empty()) out.mavlink.append(nb::make_tuple(link, bytes_of(bytes)));
          }
          for (const link::CanFrame& frame : sent.can) {
            out.can.append(nb::make_tuple(frame.id, bytes_of(frame.bytes())));
          }
        },
        boat_);
    return out;
  }

  void on_host(bool bus_up, bool parameters_saved, std::uint32_t overruns, std::int64_t unix_us,
               bool save_failed, bool clock_is_set, bool stop_pressed) {
    const app::HostReport report{.bus_up = bus_up,
                                 .why_not_to_arm = parameters_saved ? "" : app::kParametersUnsaved,
                                 .overruns = overruns,
                                 .unix_us = unix_us,
                                 .save_failed = save_failed,
                                 .stop_pressed = stop_pressed,
                                 .clock_is_set = clock_is_set};
    std::visit([&](auto& b) { b->on_host(report); }, boat_);
  }

  void secure(const nb::bytes& key, std::int64_t unix_us) {
    link::SigningKey desired{};
    const auto bytes = span_of(key);
    if (bytes.size() != desired.size()) throw nb::value_error("key: 32 bytes");
    std::copy(bytes.begin(), bytes.end(), desired.begin());
    std::visit([&](auto& b) { b->secure(desired, link::signing_time(unix_us), 0); }, boat_);
  }

  void set_signing(int link, const std::string& policy) {
    if (link < 0 || static_cast<std::size_t>(link) >= links_) throw nb::index_error("link");
    const auto desired = app::signing_policy(policy);
    if (!desired) throw nb::value_error("policy: \"off\", \"accept\" or \"required\"");
    std::visit([&](auto& b) { b->set_policy(static_cast<std::size_t>(link), *desired); }, boat_);
  }

  void limit_link(int link, std::uint32_t bytes_per_s) {
    if (link < 0 || static_cast<std::size_t>(link) >= links_) throw nb::index_error("link");
    std::visit([&](auto& b) { b->limit_link(static_cast<std::size_t>(link), bytes_per_s); }, boat_);
  }

  const char* take_save_request() {
    constexpr std::array kNames{"none", "changed", "confirmed"};
    const auto request = std::visit([](auto& b) { return b->take_save_request(); }, boat_);
    return kNames[static_cast<std::size_t>(request)];
  }

  nb::dict snapshot() const {
    return std::visit([](const auto& b) { return snapshot_dict(b->snapshot()); }, boat_);
  }

  nb::str state() const {
    return std::visit(
        [](const auto& b) {
          const auto name = app::name_of(b->state());
          return nb::str(name.data(), name.size());
        },
        boat_);
  }

  nb::dict parameters() const {
    return parameters_dict(
        std::visit([](const auto& b) -> const app::Parameters& { return b->parameters(); }, boat_));
  }

 private:
  void bring_logs(app::LogService& service) const {
    const auto request = service.request();
    if (!request) return;
    std::vector<app::StoredLog> list;
    for (const auto& log : logs_) list.push_back({static_cast<std::uint32_t>(log.size()), 0});
    if (request->list) return service.bring_list(list);
    const auto& log = logs_.at(request->log + service.left_out());
    service.bring(*request,
                  std::span(log).subspan(std::min<std::size_t>(request->offset, log.size())));
  }

  std::size_t links_;
  std::vector<std::vector<std::uint8_t>> logs_;
  std::variant<std::unique_ptr<app::Boat<float>>, std::unique_ptr<app::Boat<double>>,
               std::unique_ptr<app::Boat<core::Q16>>>
      boat_;
};

const char* name_of(app::ParameterKind kind) {
  constexpr std::array kNames{"real",  "whole",  "sign",   "identity", "autopilot",
                              "frame", "switch", "action", "stop"};
  return kNames[static_cast<std::size_t>(kind)];
}

const char* name_of(app::ParameterChange change) {
  constexpr std::array kNames{"anytime", "disarmed", "restart"};
  return kNames[static_cast<std::size_t>(change)];
}

nb::list parameter_list() {
  nb::list out;
  for (std::size_t i = 0; i < app::kParameterList.size(); ++i) {
    const app::ParameterInfo& info = app::kParameterList[i];
    const auto& [group, sentence] = app::kParameterTexts[i];
    nb::dict entry;
    entry["name"] = nb::str(info.name.data(), info.name.size());
    entry["unit"] = nb::str(info.unit.data(), info.unit.size());
    entry["default"] = info.default_value();
    entry["least"] = info.least;
    entry["greatest"] = info.greatest;
    entry["integer"] = info.whole();
    entry["group"] = nb::str(group.data(), group.size());
    entry["kind"] = name_of(info.kind);
    entry["change"] = name_of(info.change);
    entry["sentence"] = nb::str(sentence.data(), sentence.size());
    out.append(entry);
  }
  return out;
}

nb::dict derived(const nb::dict& parameters) {
  const app::Parameters all = app::derived(parameters_from(parameters));
  nb::dict out;
  for (const app::ParameterInfo& info : app::kParameterList) {
    out[nb::str(info.name.data(), info.name.size())] = all.*info.member;
  }
  return out;
}

nb::dict metadata() {
  nb::dict out;
  for (const link::FtpFile& file : app::metadata_files()) {
    std::vector<std::uint8_t> content(file.content.size());
    file.content.read(0, content);
    out[nb::str(file.name.data(), file.name.size())] = nb::bytes(content.data(), content.size());
  }
  return out;
}

}  // namespace

NB_MODULE(flotilla, m) {
  m.doc() = "Flotilla's firmware: the autopilot of a twin-propeller boat, without I/O.";
  m.attr("__version__") =
      std::to_string(app::kVersionMajor) + "." + std::to_string(app::kVersionMinor);
  m.def("parameter_list", &parameter_list,
        "Every parameter as a dictionary: name, unit, default, least and greatest value, whether "
        "it is an integer, group, kind, when it may change, and a sentence that explains it.");
  m.def("derived", &derived, "parameters"_a = nb::dict(),
        "Returns the values of all parameters by name as the law uses them, if these ones are set: "
        "a derived gain replaces each negative one.");
  m.def("metadata", &metadata,
        "The files that the boat offers by MAVLink FTP: dict[str, bytes], content by name.");
  bind_route(m);
  bind_supervisor(m);
  bind_helm(m);
  bind_fleet(m);
  nb::module_ kernels =
      m.def_submodule("kernels", "Loops over many vessels, for the package sil only.");
  plant::bind_hull(kernels);
  plant::bind_propeller(kernels);
  plant::bind_sensors(kernels);
  plant::bind_voyage(kernels);
  plant::bind_weather(kernels);
  bind_traces(kernels);
  nb::class_<TickOutput>(m, "TickOutput", "Output of a boat in one tick, in the order of sending.")
      .def_ro("mavlink", &TickOutput::mavlink, "list[tuple[int, bytes]]: link, bytes")
      .def_ro("can", &TickOutput::can, "list[tuple[int, bytes]]: 29-bit id, data");

  nb::class_<PyBoat>(
      m, "Boat",
      "One boat's firmware. parameters: values by MAVLink name, the others keep their defaults; "
      "links: number of MAVLink links, 1 to 4; scalar: number type of the law, \"float\", "
      "\"double\" or \"q16\". ValueError names a parameter that is unknown or out of range.")
      .def(nb::init<const nb::dict&, int, const std::string&>(), "parameters"_a = nb::dict(),
           "links"_a = 1, "scalar"_a = "float")
      .def("on_mavlink", &PyBoat::on_mavlink, "data"_a, "now_us"_a, "link"_a = 0,
           "Takes bytes received on a MAVLink link, in chunks of any length. now_us: the boat's "
           "own monotonic clock, microseconds.")
      .def("on_can", &PyBoat::on_can, "can_id"_a, "data"_a, "now_us"_a,
           "Takes one received CAN frame with a 29-bit id and up to 8 bytes.")
      .def("keep_logs", &PyBoat::keep_logs, "logs"_a,
           "Sets the logs, each as bytes, that clients can download from the boat over MAVLink.")
      .def("tick", &PyBoat::tick, "now_us"_a,
           "Runs one control step and returns what the boat sends. now_us: as in on_mavlink().")
      .def("on_host", &PyBoat::on_host, "bus_up"_a = true, "parameters_saved"_a = true,
           "overruns"_a = 0, "unix_us"_a = 0, "save_failed"_a = false, "clock_is_set"_a = true,
           "stop_pressed"_a = false,
           "Reports what only the boat's host knows, valid until the next report. bus_up: the CAN "
           "interface is up; parameters_saved: False forbids arming; overruns: ticks more than a "
           "period late since the start; unix_us: present time, microseconds since 1970, 0: "
           "unknown; save_failed: the last attempt to save the parameters failed; clock_is_set: "
           "False if unix_us is a guess; stop_pressed: the stop switch wired to the host is "
           "pressed.")
      .def("secure", &PyBoat::secure, "key"_a, "unix_us"_a,
           "Sets the MAVLink 2 signing key of all links, 32 bytes. unix_us: present time, "
           "microseconds since 1970.")
      .def("set_signing", &PyBoat::set_signing, "link"_a, "policy"_a,
           "Sets how a link treats signatures. \"off\": sends unsigned and ignores signatures; "
           "\"accept\": signs, and rejects wrong signatures; \"required\": also rejects unsigned "
           "messages, except a radio's RADIO_STATUS.")
      .def("limit_link", &PyBoat::limit_link, "link"_a, "bytes_per_s"_a,
           "Limits the telemetry on a link to so many bytes per second; 0: no limit.")
      .def("take_save_request", &PyBoat::take_save_request,
           "Whether and why the host should save the parameters, since the last call: \"none\", "
           "\"changed\" (an operator changed one) or \"confirmed\" (an operator asked to save "
           "them).")
      .def("snapshot", &PyBoat::snapshot,
           "Results of the last tick, in SI units: state, conditions, ages, estimates, error, "
           "virtual velocity, wrench asked and given, limits that acted, thrusts, counters.")
      .def_prop_ro("state", &PyBoat::state, "The supervisor's state after the last tick.")
      .def("parameters", &PyBoat::parameters, "Every parameter's value by name.");
}
