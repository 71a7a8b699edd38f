// SPDX-License-Identifier: MIT
// Converts thrusts to the ESCs' raw commands, and back to the wrench actually given.
#pragma once

#include <algorithm>

#include "app/convert/convert.hpp"
#include "app/parameters/configuration.hpp"
#include "core/coast.hpp"
#include "link/dronecan/messages.hpp"

namespace flotilla::app {

template <class S>
class Thrusters {
 public:
  struct Output {
    core::Thrust<S> thrust{};  ///< N, of the commands as sent
    core::Tau<S> given{};
    bool slew_limited = false;
    link::RawCommand raw{};
  };

  Thrusters(const Configuration::Propulsion& propulsion, const convert::Law<S>& law)
      : propellers_(law.controller.propellers),
        slew_(law.slew),
        port_{law.port_curve, propulsion.port_esc, propulsion.port_reversed},
        stbd_{law.stbd_curve, propulsion.stbd_esc, propulsion.stbd_reversed} {}

  /// Uses other curves from the next step on; the commands continue from their present values.
  void set_curves(const convert::Law<S>& law) {
    propellers_ = law.controller.propellers;
    port_.curve = law.port_curve;
    stbd_.curve = law.stbd_curve;
  }

  /// Zeros at once unless `drive`; else moves towards the desired thrusts at the slew rate at most.
  /// With may_rise false, neither thrust nor command exceeds the larger magnitude of the last step;
  /// both are limited because the curves ahead and astern differ.
  Output step(bool drive, const core::Thrust<S>& desired, S dt, bool may_rise = true) {
    Output out;
    out.raw.count = static_cast<std::uint8_t>(std::max(port_.index, stbd_.index) + 1);
    if (!drive) {
      port_.command = stbd_.command = S(0);
      return out;
    }
    core::Thrust<S> may = desired;
    S most = port_.curve.full;
    if (!may_rise) {
      may = core::limited(desired,
                          core::max(core::abs(thrust_of(port_)), core::abs(thrust_of(stbd_))));
      most = core::max(core::abs(port_.command), core::abs(stbd_.command));
    }
    const S port = core::clamp(core::command_from_thrust(port_.curve, may.port), -most, most),
            stbd = core::clamp(core::command_from_thrust(stbd_.curve, may.stbd), -most, most);
    out.thrust = {turn(port_, port, dt, out), turn(stbd_, stbd, dt, out)};
    out.given = core::wrench_of(propellers_, out.thrust);
    return out;
  }

 private:
  struct Propeller {
    core::ThrustCurveParams<S> curve;
    std::uint8_t index;
    bool reversed;
    S command{};
  };

  S turn(Propeller& propeller, S asked, S dt, Output& out) {
    const S command = core::limit_slew(propeller.command, asked, slew_, dt, propeller.curve.full);
    out.slew_limited = out.slew_limited || command < asked || asked < command;
    propeller.command = command;
    const std::int16_t raw = convert::raw_of(command);
    out.raw.cmd[propeller.index] = propeller.reversed ? static_cast<std::int16_t>(-raw) : raw;
    return core::thrust_from_command(propeller.curve, S(raw));
  }

  S thrust_of(const Propeller& propeller) const {
    return core::thrust_from_command(propeller.curve, S(convert::raw_of(propeller.command)));
  }

  core::AllocationParams<S> propellers_;
  S slew_;
  Propeller port_;
  Propeller stbd_;
};

}  // namespace flotilla::app
