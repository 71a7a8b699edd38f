// SPDX-License-Identifier: MIT
// The boat as a MAVLink vehicle: turns messages into requests, and states into messages. The
// supervisor decides; nothing here deals with courses or thrusts.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "app/navigation/time_requests.hpp"
#include "app/operator/copies.hpp"
#include "app/operator/identity.hpp"
#include "app/operator/inbox.hpp"
#include "app/operator/mavlink_links.hpp"
#include "app/operator/rc_input.hpp"
#include "app/operator/router.hpp"
#include "app/operator/services/log_service.hpp"
#include "app/operator/services/mission_service.hpp"
#include "app/operator/services/parameter_service.hpp"
#include "app/operator/setpoint.hpp"
#include "app/operator/setpoints.hpp"
#include "app/operator/storage.hpp"
#include "app/operator/telemetry/streams.hpp"
#include "app/operator/telemetry/telemetry.hpp"
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

  /// Begins a tick, dt_us after the previous one.
  void begin(std::int64_t now_us, std::int64_t dt_us);

  /// Another sender has used our ids within the last ten seconds.
  bool doubled(std::int64_t now_us) const { return now_us - double_us_ < 10 * kSecond_us; }

  /// The condition that a ground station is heard.
  core::Conditions conditions(std::int64_t now_us) const;

  /// Applies the automatic transitions, and announces them.
  void apply_conditions(core::Conditions conditions, link::Counters& counters);

  /// Applies the RC pilot's request, which overrides those of other operators.
  void apply_rc(link::Counters& counters);

  /// A request by the fleet's rule, judged like an operator's, with the last report. False if it is
  /// refused.
  bool obey(core::Request request, link::Counters& counters);

  /// A stop by the fleet: HOLD, if the boat is under way; requests that would undo it are dropped.
  /// False if the boat still drives.
  bool obey_stop(link::Counters& counters);

  /// Call while a stop switch is pressed: FAULT until an operator disarms the boat after its
  /// release.
  void stop(link::Counters& counters);

  /// Answers the requests since the last tick, in order, up to one that stops the boat or changes a
  /// parameter. If true, apply the change (see take_change()) and call again.
  bool answer(link::Counters& counters);

  /// Requests are pending; their answers may need a report.
  bool is_asked() const { return !inbox_.is_empty(); }

  /// Sets the origin of the local positions that we send.
  void locate(const link::GpsGlobalOrigin& origin);

  /// Whether tell() needs a report of this tick.
  bool tells_report();

  /// Sets the values that telemetry and answers use from now on.
  void report(const Report& report);

  /// Whether FORMATION_REFERENCE is due on a link; it is due earlier if `news` differs from the
  /// number sent last.
  bool waits_for_reference(std::uint32_t news) const;
  void tell_reference(std::uint32_t news, const link::FormationReference& reference,
                      link::Counters& counters);

  /// The same for FORMATION_FUTURE; each future is sent twice. future: nothing if it is over.
  bool waits_for_future(std::uint32_t news) const;
  void tell_future(std::uint32_t news, const std::optional<link::FormationFuture>& future,
                   link::Counters& counters);

  /// A request of the boat itself.
  void request(core::Request request, link::Counters& counters);

  /// Sends telemetry and pending answers.
  void tell(link::Counters& counters);

  /// Sends a text to all operators, in chunks of 50 characters if it is longer.
  void send_statustext(std::uint8_t severity, std::initializer_list<std::string_view> parts,
                       link::Counters& counters);

  MissionService& missions() { return missions_; }
  const MissionService& missions() const { return missions_; }
  LogService& logs() { return logs_; }
  /// A target that GUIDED has not begun to sail to yet.
  const std::optional<Target>& target() const { return target_; }
  std::optional<Target> take_target() { return std::exchange(target_, std::nullopt); }
  /// Velocities that a script has set for GUIDED, until it was silent for three seconds.
  std::optional<core::Drive<double>> drive(std::int64_t now_us) const;
  /// An operator has paused the plan or the errand.
  bool is_paused() const { return paused_; }

  /// Takes the progress of AUTO: the item ahead, and the last one reached. complete: the plan is at
  /// its end.
  void sailed(std::size_t item, std::optional<std::size_t> reached, bool complete,
              link::Counters& counters);

  /// Takes effect in the next tick, after all other requests.
  void disarm() { disarm_ = true; }

  link::Address self() const { return identity_.self(); }
  const Parameters& parameters() const { return parameters_; }
  const Configuration& configuration() const { return configuration_; }

  /// Whether a parameter was set, or a companion's system id was found, since the last call.
  bool take_change() { return std::exchange(changed_, false); }
  Heard take_heard() { return std::exchange(heard_, Heard::kNothing); }
  SaveRequest take_save_request() { return std::exchange(save_, SaveRequest::kNone); }

  /// Lets the host judge MAV_CMD_INJECT_FAILURE; without a judge the command is unsupported.
  void let_failures_be_injected(FailureJudge by) { failure_judge_ = by; }
  std::optional<Failure> take_failure() { return std::exchange(failure_, std::nullopt); }

 private:
  static constexpr std::int64_t kSecond_us = 1'000'000;

  // Rare work is cold: inlined, it would enlarge the stack of `take`, which handles every state.
  [[gnu::cold]] void take_sticks(const link::Received& received, const link::ManualControl& sticks,
                                 std::int64_t now_us, link::Counters& counters);
  bool take_rc(const link::Received& received, std::int64_t now_us);
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
  std::uint8_t answer_of_jump(DecodedCommand& asked);
  std::uint8_t answer_of_plan(DecodedCommand& asked);
  void judge_order(const PendingRequest& pending, bool repeated, DecodedCommand& asked);
  void judge_target(DecodedCommand& asked) const;
  void take_setpoint(const PendingRequest& pending);
  std::uint8_t answer_of_fence(DecodedCommand& asked);
  std::optional<PlanReport> plan_report() const;
  void refresh();
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
  void send_complaints(std::string_view what, core::Conditions unmet, link::Counters& counters);
  void announce_state(core::Conditions missing, link::Counters& counters);
  link::Heartbeat heartbeat() const;
  /// The state messages of one tick, shared by all links.
  using StateMessages = std::array<std::optional<link::Message>, kStateStreams.size()>;
  void ask_times(link::Counters& counters);
  void ask_leaders_time(link::Counters& counters);
  void tell_separation(link::Counters& counters);
  bool state_is_due();
  bool reference_is_due(std::size_t link, std::uint32_t news) const;
  bool future_is_due(std::size_t link, std::uint32_t news) const;
  void tell_state(link::Counters& counters);
  void tell_state(std::size_t link, StateMessages& state, link::Counters& counters);
  void tell_rest(std::size_t link, link::Counters& counters);
  bool may_tell(std::size_t link) const;
  bool tell_stream(std::size_t stream, std::size_t link, link::Counters& counters);
  bool tell_parameters(std::size_t link, link::Counters& counters);
  bool tell_files(std::size_t link, link::Counters& counters);
  bool tell_logs(std::size_t link, link::Counters& counters);

  Supervisor& supervisor_;
  Parameters parameters_;
  Configuration configuration_;  // derived from parameters_
  Identity identity_;
  MavlinkLinks& links_;
  TimeRequests& time_;
  Router router_;
  Inbox inbox_;
  Copies copies_;
  ParameterService parameter_service_;
  MissionService missions_;
  LogService logs_;
  struct Stop {
    std::int64_t us = 0;
    link::Address by{};
    std::uint8_t links = 0;  ///< it came on, by bits; 0: none yet
  };
  Stop stop_;  // an operator's last one
  bool paused_ = false;
  std::optional<Target> target_;
  std::optional<core::Drive<double>> drive_;  // in GUIDED
  std::int64_t drive_us_ = 0;
  std::optional<std::size_t> reached_;  // item
  link::FtpServer ftp_;
  Streams streams_;
  Setpoints setpoints_;
  RcInput rc_;
  Report report_;  // the last one, with the present mode

  std::optional<std::int64_t> gcs_us_;  // last heartbeat of one that may command
  bool changed_ = false;
  SaveRequest save_ = SaveRequest::kNone;
  Heard heard_ = Heard::kNothing;
  FailureJudge failure_judge_ = nullptr;
  std::optional<Failure> failure_;
  bool disarm_ = false;
  std::string_view ignored_{};  // refusal_of() a message since the last tick
  bool double_seen_ = false;    // since the last warning of it
  std::int64_t double_us_ = std::numeric_limits<std::int64_t>::min() / 2;
  bool announce_ = false;  // the state has changed: send a heartbeat at once
  std::optional<std::array<std::int32_t, 2>> told_origin_;
  bool origin_moved_ = false;  // in this tick
  std::array<std::uint32_t, kMaxLinks> told_news_{};
  struct StateTurns {
    std::uint8_t states = 0;      ///< sent since the last reference
    bool reference_next = false;  ///< it waits for the link's budget
  };
  std::array<StateTurns, kMaxLinks> state_turns_{};
  struct ToldFuture {
    std::uint32_t news = 0;
    bool again = false;
  };
  std::array<ToldFuture, kMaxLinks> told_futures_{};
  std::array<std::size_t, kMaxLinks> turn_{};  // the next turn of tell_rest()
  struct Begun {
    std::size_t stream = kStreams.size();
    std::uint32_t told = 0;
  };
  std::array<Begun, kMaxLinks> begun_{};  // a stream that has sent only part of its messages
  std::uint16_t text_id_ = 0;
  std::int64_t now_us_ = 0;

  Schedule heartbeat_due_;
  Schedule timesync_due_;
  Schedule leader_time_due_{250'000};
  std::int64_t asked_everywhere_us_ = std::numeric_limits<std::int64_t>::min() / 2;
  Schedule separation_due_;
  Schedule arm_refusal_due_;
  Schedule refusal_due_;
  Schedule stop_due_;
  Schedule parameter_refusal_due_;
  Schedule double_due_;
  Schedule ignored_due_;
  Schedule signing_due_;
};

}  // namespace flotilla::app
