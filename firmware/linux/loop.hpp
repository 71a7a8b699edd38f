// SPDX-License-Identifier: MIT
// The control loop: connects one boat to buses, links and the operating system's clock.
#pragma once

#include <cstdint>
#include <filesystem>
#include <list>
#include <memory>
#include <optional>
#include <vector>

#include "app/boat/boat.hpp"
#include "app/boat/law_scalar.hpp"
#include "linux/can/can_bus.hpp"
#include "linux/config/config.hpp"
#include "linux/files/node_table.hpp"
#include "linux/files/plan_file.hpp"
#include "linux/files/saved_parameters.hpp"
#include "linux/files/signing_time.hpp"
#include "linux/logs/line_writer.hpp"
#include "linux/logs/log_reader.hpp"
#include "linux/logs/logs.hpp"
#include "linux/mavlink/mavlink_endpoint.hpp"
#include "linux/service_manager.hpp"
#include "linux/statistics.hpp"
#include "linux/system/file_descriptor.hpp"
#include "linux/system/repeating_thread.hpp"
#include "linux/system/stop_switch.hpp"

namespace flotilla::target {

class Loop {
 public:
  /// Opens the devices that are present; the others are retried. Throws std::runtime_error that
  /// names a mistake in the configuration.
  explicit Loop(const Config& config);

  /// Ticks until SIGTERM or SIGINT, stops the propellers, saves; returns the exit status.
  int run();

 private:
  void secure();
  void restore_plans();
  bool keep_lists();
  std::string_view unsaved_list() const;
  std::string_view why_not_to_arm() const;
  void ask_for_real_time();
  void wait();
  void read_links(std::int64_t now_us);
  void read_bus(std::int64_t now_us);
  void tick();
  void send(const app::Boat<Scalar>::Output& out, std::int64_t now_us);
  void keep_house(std::int64_t now_us);
  void bring_logs();
  void maintain_devices(std::int64_t now_us);
  void shut_down();

  LineWriter messages_;
  Config config_;
  SavedParameters parameters_;
  std::unique_ptr<app::Boat<Scalar>> boat_;
  std::unique_ptr<CanBus> bus_;
  bool bus_usable_ = true;  // as last reported
  std::vector<std::unique_ptr<MavlinkEndpoint>> links_;
  std::uint8_t closed_links_ = 0;  // bit mask, as last reported
  NodeTable node_table_;
  /// Of plan, fence and rally points.
  struct Kept {
    app::Stored kind;
    std::filesystem::path file;
    PlanSaver saver;
    std::uint32_t saved = 0;  // id

    Kept(app::Stored which, const std::filesystem::path& path)
        : kind(which), file(path), saver(path) {}
  };
  std::list<Kept> kept_;
  Logs logs_;
  std::optional<LogReader> log_reader_;      // only with logs
  std::optional<SigningTime> signing_time_;  // only with a key
  ServiceManager service_manager_;
  StopSwitch stop_;
  int stop_error_ = 0;  // as last reported

  FileDescriptor timer_;
  FileDescriptor signals_;
  std::int64_t period_us_;
  std::int64_t deadline_us_ = 0;
  bool timer_fired_ = false;
  bool stopping_ = false;
  std::int64_t house_kept_us_ = 0;

  std::int64_t heard_us_ = 0;  // first bytes since the last tick; 0: none
  Statistics statistics_;
  std::list<RepeatingThread> openers_;  // one per device, so that none waits for another
};

}  // namespace flotilla::target
