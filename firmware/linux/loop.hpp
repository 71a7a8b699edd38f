// SPDX-License-Identifier: MIT
// The control loop: connects one boat to buses, links and the operating system's clock.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/boat.hpp"
#include "app/law_scalar.hpp"
#include "linux/can_bus.hpp"
#include "linux/config.hpp"
#include "linux/file_descriptor.hpp"
#include "linux/latency.hpp"
#include "linux/logs.hpp"
#include "linux/mavlink_endpoint.hpp"
#include "linux/node_table.hpp"
#include "linux/parameter_file.hpp"
#include "linux/parameter_saver.hpp"
#include "linux/service_manager.hpp"
#include "linux/signing_time.hpp"

namespace flotilla::target {

class Loop {
 public:
  /// Opens everything. Throws std::runtime_error that names the mistake in the configuration.
  explicit Loop(const Config& config);

  /// Ticks until SIGTERM, SIGINT or SIGHUP, stops the propellers, saves; returns the exit status.
  int run();

 private:
  void secure();
  void wait();
  void read_links(std::int64_t now_us);
  void read_bus(std::int64_t now_us);
  void tick();
  void send(const app::Boat<Scalar>::Output& out, std::int64_t now_us);
  void keep_house(std::int64_t now_us);
  void note_changes();
  void save_changes(std::int64_t now_us);
  void report_outcome();
  void report_saved(std::string_view why, const std::optional<std::string>& fault);
  void shut_down();
  void write_stats() const;

  Config config_;
  LoadedParameters parameters_;  // as they should be on the disk
  std::unique_ptr<app::Boat<Scalar>> boat_;
  app::Parameters noted_;  // the boat's, at the last note_changes()
  app::SaveRequest to_save_ = app::SaveRequest::kNone;
  std::int64_t saved_us_ = 0;  // start of the last save
  bool save_failed_ = false;   // the last save failed, which was reported
  ParameterSaver saver_;
  std::unique_ptr<CanBus> bus_;
  bool bus_usable_ = true;  // as last reported
  std::vector<std::unique_ptr<MavlinkEndpoint>> links_;
  NodeTable node_table_;
  Logs logs_;
  std::optional<SigningTime> signing_time_;  // only with a key
  ServiceManager service_manager_;

  FileDescriptor timer_;
  FileDescriptor signals_;
  std::int64_t period_us_;
  std::int64_t deadline_us_ = 0;
  bool timer_fired_ = false;
  bool stopping_ = false;
  std::uint32_t overruns_ = 0;
  std::int64_t house_kept_us_ = 0;

  std::int64_t heard_us_ = 0;  // first bytes since the last tick; 0: none
  Latency lateness_;           // of the wake-up
  Latency processing_;         // from the tick's start until the command is sent
  Latency response_;           // from the first bytes received until the command is sent
};

}  // namespace flotilla::target
