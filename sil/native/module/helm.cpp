// SPDX-License-Identifier: MIT
#include "helm.hpp"

#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <tuple>
#include <vector>

#include "app/convert/law.hpp"
#include "values.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using namespace flotilla;

namespace {

/// The boat's observer and law without messages, in double precision: takes fixes and the leader's
/// motion, returns thrusts. Positions in metres, north-east.
class Helm {
 public:
  using State = std::array<double, 22>;
  using Leader = std::array<double, 9>;

  explicit Helm(const nb::dict& parameters) {
    const auto law = app::convert::law_of<double>(parameters_from(parameters));
    law_ = law.controller;
    observer_ = law.observer;
  }

  void fix(double x, double y, double psi, double u, double v, double r, double age, double dt) {
    fix_at_ = {x, y};
    fix_ = core::Fix<double>{{}, psi, {u, v, r}, age, dt};
  }

  struct Step {
    core::ControllerOutput<double> law;
    core::ControllerInput<double> in;
  };

  Step step(const Leader& l, double h, bool drive) {
    core::observer_forward(law_.vessel, own_, given_, h);
    take_fix();
    const core::ControllerInput<double> in{
        {anchor_.x + own_.motion.moved_n.x - l[0], anchor_.y + own_.motion.moved_n.y - l[1]},
        own_.motion.psi,
        l[2],
        own_.motion.nu,
        {l[3], l[4], l[5]},
        {l[6], l[7], l[8]},
        own_.c_n,
        core::unknown_wrench(law_.vessel, own_)};
    if (!started_) state_ = core::controller_start(in);
    const auto out = core::controller_step(law_, state_, in, started_ ? h : 0.0);
    started_ = drive;
    given_ = drive ? out.allocation.given : core::Tau<double>{};
    return {out, in};
  }

  nb::dict told_step(const Leader& l, double h, bool drive) {
    const Step made = step(l, h, drive);
    return told(made.law, made.in, drive);
  }

  /// x, y, ψ, u, v, r; unknown accelerations of the three; current north, east; v*, u* and r* held;
  /// sway of the slot, its speed and slip with their rates; approach: 1 bow first, −1 stern first,
  /// 0 none; wrench given.
  State state() const {
    const auto& m = own_.motion;
    return {anchor_.x + m.moved_n.x,
            anchor_.y + m.moved_n.y,
            m.psi,
            m.nu.u,
            m.nu.v,
            m.nu.r,
            own_.b.u,
            own_.b.v,
            own_.b.r,
            own_.c_n.x,
            own_.c_n.y,
            state_.outer.v_star,
            state_.outer.u_star_held,
            state_.outer.r_star_held,
            state_.slot.v_w,
            state_.slot.q_s.value,
            state_.slot.q_s.rate,
            state_.slot.n.value,
            state_.slot.n.rate,
            state_.approach.on ? (state_.approach.astern ? -1.0 : 1.0) : 0.0,
            given_.X,
            given_.N};
  }

  void set_state(const State& s) {
    anchor_ = {s[0], s[1]};
    own_.motion = {{}, s[2], {s[3], s[4], s[5]}, {}};
    own_.b = {s[6], s[7], s[8]};
    own_.c_n = {s[9], s[10]};
    own_.given = {};
    state_ = {{s[11], s[12], s[13]}, {s[14], {s[15], s[16]}, {s[17], s[18]}, true}};
    state_.approach = {std::abs(s[19]) > 0.5, s[19] < -0.5};
    given_ = {s[20], s[21]};
    fix_.reset();
    started_ = true;
  }

 private:
  void take_fix() {
    if (!fix_) return;
    fix_->expected_n = {anchor_.x + own_.motion.moved_n.x - fix_at_.x,
                        anchor_.y + own_.motion.moved_n.y - fix_at_.y};
    core::observer_correct(observer_, law_.vessel, own_, *fix_);
    anchor_ = fix_at_;
    fix_.reset();
  }

  static nb::dict told(const core::ControllerOutput<double>& law,
                       const core::ControllerInput<double>& in, bool drive) {
    const core::Error<double>& e = law.error.e;
    const core::Nu<double>& star = law.desired.nu_star;
    const core::Allocation<double>& a = law.allocation;
    const core::Thrust<double> thrust = drive ? a.thrust : core::Thrust<double>{};
    nb::dict out;
    out["error"] = triple("x_m", e.x, "y_m", e.y, "psi_rad", e.psi);
    out["virtual_velocity"] = triple("u_mps", star.u, "v_mps", star.v, "r_radps", star.r);
    out["wrench_asked"] = pair("X_N", law.tau.X, "N_Nm", law.tau.N);
    out["wrench_given"] = pair("X_N", a.given.X, "N_Nm", a.given.N);
    out["thrust_N"] = pair("port", thrust.port, "stbd", thrust.stbd);
    out["unknown"] = pair("X_N", in.unknown.X, "N_Nm", in.unknown.N);
    out["current_mps"] = pair("north", in.current_n.x, "east", in.current_n.y);
    return out;
  }

  core::ControllerParams<double> law_;
  core::ObserverParams<double> observer_;
  core::ControllerState<double> state_{};
  core::Observer<double> own_{};
  core::Vec2<double> anchor_{}, fix_at_{};
  std::optional<core::Fix<double>> fix_;
  core::Tau<double> given_{};
  bool started_ = false;
};

template <int N, class T = const double>
using Rows = nb::ndarray<T, nb::shape<-1, N>, nb::c_contig, nb::device::cpu>;

/// Copies of a Helm that step together, one row each.
class Helms {
 public:
  static constexpr int kState = std::tuple_size_v<Helm::State>;

  Helms(const nb::dict& parameters, std::size_t count) : helms_(count, Helm(parameters)) {}

  void fix(const Rows<3>& eta, const Rows<3>& nu, double age, double dt) {
    check(eta.shape(0));
    check(nu.shape(0));
    for (std::size_t i = 0; i < helms_.size(); ++i)
      helms_[i].fix(eta(i, 0), eta(i, 1), eta(i, 2), nu(i, 0), nu(i, 1), nu(i, 2), age, dt);
  }

  double step(const Helm::Leader& leader, double h, const Rows<2, double>& thrust) {
    check(thrust.shape(0));
    double most = 0.0;
    for (std::size_t i = 0; i < helms_.size(); ++i) {
      const core::ControllerOutput<double> law = helms_[i].step(leader, h, true).law;
      const core::Allocation<double>& a = law.allocation;
      thrust(i, 0) = a.thrust.port;
      thrust(i, 1) = a.thrust.stbd;
      most = std::max(most, std::abs(law.tau.X - a.given.X) + std::abs(law.tau.N - a.given.N));
    }
    return most;
  }

  void state(const Rows<kState, double>& rows) const {
    check(rows.shape(0));
    for (std::size_t i = 0; i < helms_.size(); ++i)
      std::ranges::copy(helms_[i].state(), &rows(i, 0));
  }

  void set_state(const Rows<kState>& rows) {
    check(rows.shape(0));
    Helm::State one;
    for (std::size_t i = 0; i < helms_.size(); ++i) {
      std::copy_n(&rows(i, 0), one.size(), one.begin());
      helms_[i].set_state(one);
    }
  }

 private:
  void check(std::size_t rows) const {
    if (rows != helms_.size()) throw nb::value_error("as many rows are needed as there are helms");
  }

  std::vector<Helm> helms_;
};

}  // namespace

void bind_helm(nb::module_& m) {
  nb::class_<Helm>(m, "Helm",
                   "The boat's observer and control law alone, without messages, supervisor and "
                   "ESCs: for certificates and experiments. Metres, radians, seconds; positions "
                   "are north and east. parameters: values by MAVLink name, the others keep their "
                   "defaults.")
      .def(nb::init<const nb::dict&>(), "parameters"_a = nb::dict())
      .def("fix", &Helm::fix, "x_m"_a, "y_m"_a, "psi_rad"_a, "u_mps"_a, "v_mps"_a, "r_radps"_a,
           "age_s"_a = 0.0, "dt_s"_a = 0.0,
           "Sets the boat's measured state for the next step. age_s: its age at that step; dt_s: "
           "time since the previous fix, 0 for the first.")
      .def("step", &Helm::told_step, "leader"_a, "h_s"_a, "drive"_a = true,
           "Runs one control step, h_s after the previous one. leader: its present x, y, psi, u, "
           "v, r and the rates of change of u, v, r; drive: False stops the propellers (thrust_N "
           "0). Returns the law's results by name, as in Boat.snapshot().")
      .def_prop_rw("state", &Helm::state, &Helm::set_state,
                   "Memory of the observer and the law, 22 numbers: x, y, psi, u, v, r; unknown "
                   "acceleration in surge, sway, yaw; current north, east; v*, u*, r* held; sway "
                   "of the slot, its speed and slip with their rates; approach: 1 bow first, -1 "
                   "stern first, 0 none; wrench given X, N. The recent wrenches, which predict a "
                   "late fix up to now, are not included.");
  nb::class_<Helms>(m, "Helms",
                    "`count` Helms with the same parameters that step together. Arrays have one "
                    "row for each Helm (n = count), double precision and C order. ValueError for "
                    "another number of rows.")
      .def(nb::init<const nb::dict&, std::size_t>(), "parameters"_a, "count"_a)
      .def("fix", &Helms::fix, "eta"_a, "nu"_a, "age_s"_a = 0.0, "dt_s"_a = 0.0,
           "Helm.fix() of each: eta (n, 3) and nu (n, 3).")
      .def("step", &Helms::step, "leader"_a, "h_s"_a, "thrust_N"_a.noconvert(),
           "Helm.step() of each, behind the same leader. Writes thrust_N (n, 2), port and "
           "starboard. Returns the greatest difference between the wrench asked and the wrench "
           "given, |X| + |N|.")
      .def("state", &Helms::state, "rows"_a.noconvert(),
           "Writes the Helm.state of each into rows (n, 22).")
      .def("set_state", &Helms::set_state, "rows"_a,
           "Sets the Helm.state of each from rows (n, 22).");
}
