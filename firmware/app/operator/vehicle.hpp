// SPDX-License-Identifier: MIT
// The boat as a MAVLink vehicle: turns messages into requests, and states into messages. The
// supervisor decides; nothing here deals with courses or thrusts.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string_view>
#include <utility>

#include "app/navigation/time_requests.hpp"
#include "app/operator/identity.hpp"
#include "app/operator/mavlink_links.hpp"
#include "app/operator/requests/copies.hpp"
#include "app/operator/requests/inbox.hpp"
#include "app/operator/requests/rc_pilots.hpp"
#include "app/operator/requests/recent_orders.hpp"
#include "app/operator/requests/sailing_orders.hpp"
#include "app/operator/requests/setpoint.hpp"
#include "app/operator/requests/setpoints.hpp"
#include "app/operator/router.hpp"
#include "app/operator/services/log_service.hpp"
#include "app/operator/services/mission_service.hpp"
#include "app/operator/services/parameter_service.hpp"
#include "app/operator/storage.hpp"
#include "app/operator/telemetry/status_texts.hpp"
#include "app/operator/telemetry/telemetry_sender.hpp"
#include "app/operator/timesync_sender.hpp"
#include "app/supervisor.hpp"
#include "link/mavlink/ftp_server.hpp"

namespace flotilla::app {

/// The best message from another sender since the host's last query: one that the link's policy
/// accepts, or one with a good signature.
enum class Heard : std::uint8_t { kNothing, kMessage, kSigned };

/// Why the host should save the parameters; a later enumerator prevails.
enum class SaveRequest : std::uint8_t {
  kNone,
  kChanged,    ///< an operator has changed one
  kConfirmed,  ///< an operator has asked to save, which confirms the values in force
};

class Vehicle {
 public:
  /// Sends on `links`, and TIMESYNC requests by `time`; both must outlive the vehicle.
  Vehicle(const Parameters& parameters, Supervisor& supervisor, MavlinkLinks& links,
          TimeRequests& time, const Storage& storage);

  /// Takes a message received on this link: keeps a request for the tick, forwards a message for
  /// others. False if the message is for navigation.
  bool take(std::size_t link, const link::Received& received, std::int64_t now_us,
            link::Counters& counters);

  void limit_link(std::size_t link, std::uint32_t bytes_per_s) {
    links_.bucket(link).limit(bytes_per_s);
    sender_.streams().limit(link, bytes_per_s);
  }

  /// Begins a tick, dt_us after the previous one.
  void begin(std::int64_t now_us, std::int64_t dt_us);

  /// Another sender has used our ids within the last ten seconds.
  bool doubled(std::int64_t now_us) const { return identity_.doubled(now_us); }

  /// core::kGcsHeard and core::kGainsFit.
  core::Conditions conditions(std::int64_t now_us) const;

  /// Applies the automatic transitions, and announces them.
  void apply_conditions(core::Conditions conditions, link::Counters& counters);

  /// Applies the RC pilot's request, which overrides those of other operators.
  void apply_rc(link::Counters& counters);

  /// Takes a request of the fleet's rule, judged like an operator's, by the last report. False if
  /// it is refused.
  bool obey(core::Request request, link::Counters& counters);

  /// Takes a stop by the fleet: HOLD if the boat is under way; drops requests that would undo it.
  /// False if the boat still drives.
  bool obey_stop(link::Counters& counters);

  /// Call while a stop switch is pressed: FAULT until an operator disarms the boat after its
  /// release.
  void stop(link::Counters& counters);

  /// Answers the requests since the last tick, in order, up to one that stops the boat, changes
  /// its state or changes a parameter. If true, apply any change (see take_change()), call again.
  bool answer(link::Counters& counters);

  /// Whether requests are pending, whose answers may need a report.
  bool is_asked() const { return !inbox_.is_empty(); }

  /// Sets the origin of the local positions that we send.
  void locate(const link::GpsGlobalOrigin& origin);

  /// Whether tell() needs a report of this tick.
  bool tells_report() { return sender_.needs_report(); }

  /// Sets the values that telemetry and answers use from now on.
  void report(const Report& report);

  /// Takes a request of the boat itself.
  void request(core::Request request, link::Counters& counters);

  /// Sends telemetry and pending answers.
  void tell(link::Counters& counters);

  TelemetrySender& sender() { return sender_; }
  StatusTexts& texts() { return texts_; }
  SailingOrders& orders() { return orders_; }
  const SailingOrders& orders() const { return orders_; }
  MissionService& missions() { return missions_; }
  const MissionService& missions() const { return missions_; }
  LogService& logs() { return logs_; }

  /// Reports the progress of AUTO: the item ahead, and the last one reached. complete: the plan is
  /// at its end.
  void report_progress(const PlanMark& ahead, std::optional<std::size_t> reached, bool complete,
                       link::Counters& counters);

  /// Disarms the boat in the next tick, after all other requests.
  void disarm() { disarm_ = true; }

  link::Address self() const { return identity_.self(); }
  const Parameters& parameters() const { return parameters_; }
  const Configuration& configuration() const { return configuration_; }

  /// Whether a parameter was set, or a companion's system id was found, since the last call.
  bool take_change() { return std::exchange(changed_, false); }
  Heard take_heard() { return std::exchange(heard_, Heard::kNothing); }
  SaveRequest take_save_request() { return std::exchange(save_, SaveRequest::kNone); }

  /// Lets the host judge MAV_CMD_INJECT_FAILURE; without a judge the command is unsupported.
  void let_failures_be_injected(FailureJudge by) { failures_.let(by); }
  std::optional<Failure> take_failure() { return failures_.take(); }

 private:
  static constexpr std::int64_t kSecond_us = 1'000'000;

  // Rare work is cold: inlined, it would enlarge the stack of `take`, which handles every state.
  [[gnu::cold]] void take_sticks(std::size_t link, link::Address from,
                                 const link::ManualControl& sticks, std::int64_t now_us,
                                 link::Counters& counters);
  [[gnu::cold]] void keep(std::size_t link, const link::Received& received,
                          const RequestMessage& request, std::int64_t now_us,
                          link::Counters& counters);
  [[gnu::cold]] void take_beat(link::Address from, const link::Heartbeat& beat,
                               std::int64_t now_us);
  [[gnu::cold]] void forward(std::size_t link, const link::Received& received, std::int64_t now_us,
                             link::Counters& counters);
  bool may_command(link::Address from) const;

  void answer(const PendingRequest& pending, link::Counters& counters);
  void execute(const PendingRequest& pending, const Command& command, link::Counters& counters);
  void answer_log(const PendingRequest& pending);
  void answer_mission(const PendingRequest& pending, link::Counters& counters);
  void tell_mission_news(link::Counters& counters);
  std::uint8_t answer_of_item(DecodedCommand& asked);
  std::uint8_t answer_of_plan(DecodedCommand& asked, bool repeated);
  void screen(const PendingRequest& pending, const Command& command, DecodedCommand& asked);
  void judge_target(DecodedCommand& asked) const;
  void take_setpoint(const PendingRequest& pending);
  std::uint8_t answer_of_fence(DecodedCommand& asked, bool repeated);
  void acknowledge(const PendingRequest& pending, const Command& command, std::uint8_t result,
                   link::Counters& counters);
  void tell_decision(const DecodedCommand& asked, const Supervisor::Decision& decision,
                     link::Counters& counters);
  std::optional<PlanReport> plan_report() const;
  void refresh();
  bool is_barred(core::Request request) const;
  void drop_orders(link::Counters& counters);
  Supervisor::Decision judge(core::Request request);
  std::optional<convert::Position> place() const;
  Supervisor::Decision ask(DecodedCommand& asked);
  void warn_of_signing(link::Counters& counters);
  std::uint8_t answer_of(std::size_t link, const MessageRequest& request) const;
  void send_requested(std::size_t link, const MessageRequest& request, link::Counters& counters);
  std::optional<link::Message> requested(std::size_t link, const MessageRequest& request,
                                         std::uint32_t turn) const;
  void set_parameter(const PendingRequest& pending, const link::ParamSet& asked,
                     link::Counters& counters);
  void refuse(core::Request request, core::Conditions missing, link::Counters& counters);
  void tell_gain_fault(link::Counters& counters);
  void announce_state(core::Conditions missing, link::Counters& counters);
  link::Heartbeat heartbeat() const;

  Supervisor& supervisor_;
  Parameters parameters_;
  Configuration configuration_;  // derived from parameters_
  Identity identity_;
  MavlinkLinks& links_;
  Router router_;
  Inbox inbox_;
  Copies copies_;
  StreamLink stick_link_, setpoint_link_;
  ParameterService parameter_service_;
  MissionService missions_;
  LogService logs_;
  link::FtpServer ftp_;
  Report report_;  // the last one, with the present mode
  TelemetrySender sender_;
  StatusTexts texts_;
  TimesyncSender timesync_;
  SailingOrders orders_;
  RecentOrders recent_;
  std::optional<std::size_t> reached_;  // last item reached
  Setpoints setpoints_;
  RcPilots rc_;
  std::optional<std::int64_t> gcs_us_;  // last heartbeat of one that may command
  bool changed_ = false;
  SaveRequest save_ = SaveRequest::kNone;
  Heard heard_ = Heard::kNothing;
  InjectedFailures failures_;
  bool disarm_ = false;
  std::string_view ignored_{};  // why a message since the last tick was ignored
  bool announce_ = false;       // the state has changed: send a heartbeat at once
  std::int64_t now_us_ = 0;

  Schedule heartbeat_due_;
};

}  // namespace flotilla::app
