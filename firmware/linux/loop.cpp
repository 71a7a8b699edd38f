// SPDX-License-Identifier: MIT
#include "linux/loop.hpp"

#include <poll.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/signalfd.h>
#include <sys/timerfd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <ctime>
#include <stdexcept>
#include <utility>

#include "linux/files/signing_key.hpp"
#include "linux/mavlink/datagrams.hpp"

namespace flotilla::target {
namespace {

constexpr std::int64_t kSecond_us = 1'000'000;
constexpr std::int64_t kHouse_us = 100'000;
constexpr std::chrono::milliseconds kReopen{100};
constexpr int kFarewellTicks = 10;
// A stored signing timestamp is reported if it is further ahead of the clock than this.
constexpr std::uint64_t kStampsPerSecond = 100'000, kWorthReporting = 60 * kStampsPerSecond;
// Greatest number of frames and chunks read between checks of the timer: a flood must not stop the
// tick.
constexpr int kMaxFrames = 256, kMaxChunks = 64;
constexpr std::int64_t kReadBeforeTick_us = 1000;

std::int64_t clock_us(clockid_t clock) {
  timespec t{};
  ::clock_gettime(clock, &t);
  return std::int64_t{t.tv_sec} * kSecond_us + t.tv_nsec / 1000;
}

std::int64_t now() { return clock_us(CLOCK_MONOTONIC); }

timespec time_of(std::int64_t us) { return {us / kSecond_us, us % kSecond_us * 1000}; }

FileDescriptor catch_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGINT);
  ::sigprocmask(SIG_BLOCK, &set, nullptr);
  ::signal(SIGHUP, SIG_IGN);   // ignore SIGHUP: the terminal may close, or a reload be asked for
  ::signal(SIGPIPE, SIG_IGN);  // ignore SIGPIPE: a reader may close stdout
  return FileDescriptor(::signalfd(-1, &set, SFD_NONBLOCK | SFD_CLOEXEC));
}

/// The parameters in force: the saved ones, overridden by the configuration.
app::Parameters in_force(const Config& config, const SavedParameters& saved) {
  app::Parameters values = saved.values();
  apply(config.param, values);
  if (const auto sentence = app::contradiction(values)) {
    throw std::runtime_error(std::string(*sentence));
  }
  return values;
}

}  // namespace

Loop::Loop(const Config& config)
    : config_(config),
      parameters_(config.parameter_file()),
      boat_(std::make_unique<app::Boat<Scalar>>(in_force(config, parameters_),
                                                config.mavlink.size())),
      bus_(open_can_bus(config.can, static_cast<std::uint8_t>(boat_->parameters().CAN_NODE))),
      node_table_(config.node_id_file()),
      logs_({.directory = config.log,
             .can_name = candump_name(config.can),
             .links = config.mavlink.size()}),
      stop_(config.stop.chip, config.stop.line),
      timer_(::timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC)),
      signals_(catch_signals()),
      period_us_(std::lround(1e6 / double{boat_->parameters().CTL_RATE})) {
  parameters_.begin(boat_->parameters());
  for (std::size_t i = 0; i < config.mavlink.size(); ++i) {
    links_.push_back(open_mavlink_endpoint(config.mavlink[i].address));
    boat_->limit_link(i, config.mavlink[i].bytes_per_s);
    if (links_.back()->datagrams()) boat_->set_datagrams(i);
    boat_->set_policy(i, config.policy(config.mavlink[i]));
  }
  if (!config.signing_key.empty()) secure();
  stop_.reopen();
  node_table_.load(boat_->node_ids());
  restore_plans();
  if (!config.log.empty()) {
    log_reader_.emplace(config.log);
    boat_->logs().open();
  }
  openers_.emplace_back(kReopen, [this] { bus_->reopen(); }, "the CAN bus");
  for (const auto& link : links_) {
    openers_.emplace_back(kReopen, [&link] { link->reopen(); }, "a MAVLink link");
  }
  openers_.emplace_back(kReopen, [this] { stop_.reopen(); }, "the stop switch");
  for (const std::string& note : parameters_.notes()) messages_.put(note);
}

/// Restores the fence first, because rally points are judged by it.
void Loop::restore_plans() {
  using app::Stored;
  const auto files = config_.plan_files();
  for (const Stored kind : {Stored::kFence, Stored::kRally, Stored::kPlan}) {
    Kept& kept = kept_.emplace_back(kind, files[static_cast<std::size_t>(kind)]);
    const LoadedPlan stored = load_plan(kept.file);
    if (!stored.note.empty()) messages_.put(stored.note);
    const app::PlanFault fault = boat_->restore(kind, stored.items);
    if (fault) {
      messages_.put(kept.file.filename().string() + " is not used: " + std::string(fault.why));
    }
    if (kind == Stored::kFence && (fault || !stored.note.empty())) boat_->lose_fence();
    kept.saved = boat_->stored_id(kind);
  }
}

/// Passes changed lists to their savers; false: try again.
bool Loop::keep_lists() {
  bool all = node_table_.save(boat_->node_ids());
  for (Kept& kept : kept_) {
    const std::uint32_t id = boat_->stored_id(kept.kind);
    if (id == kept.saved) continue;
    if (kept.saver.put(boat_->stored(kept.kind))) {
      kept.saved = id;
    } else {
      all = false;
    }
  }
  return all;
}

void Loop::secure() {
  const link::SigningKey key = read_signing_key(config_.signing_key);
  const StoredSigningTime stored = load_signing_time(config_.signing_time_file());
  if (!stored.note.empty()) messages_.put(stored.note);
  const std::uint64_t clock = link::signing_time(clock_us(CLOCK_REALTIME));
  if (stored.timestamp > clock + kWorthReporting) {
    messages_.put("the clock is " + std::to_string((stored.timestamp - clock) / kStampsPerSecond) +
                  " s behind " + config_.signing_time_file().filename().string() +
                  ": messages signed by other clocks may be refused");
  }
  boat_->secure(key, clock, stored.timestamp);
  signing_time_.emplace(config_.signing_time_file(), boat_->signing_timestamp());
  if (!signing_time_->clock_is_set()) {
    messages_.put(
        "the clock is not set: old signatures may be accepted until the navigation unit sends the "
        "time");
  }
  for (const MavlinkLinkConfig& link : config_.mavlink) {
    if (config_.policy(link) == app::SigningPolicy::kRequired) continue;
    messages_.put("unsigned messages are accepted on " + link.address);
  }
}

/// Real-time priority and locked memory are optional: without them the boat sails and reports it.
void Loop::ask_for_real_time() {
  if (config_.priority > 0) {
    sched_param desired{};
    desired.sched_priority = config_.priority;
    if (::sched_setscheduler(0, SCHED_FIFO, &desired) != 0) {
      messages_.put("SCHED_FIFO refused (" + std::string(std::strerror(errno)) +
                    "): running at normal priority");
    }
  }
  if (config_.lock_memory && ::mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
    messages_.put("locked memory refused (" + std::string(std::strerror(errno)) +
                  "): memory may be swapped out");
  }
}

int Loop::run() {
  ask_for_real_time();
  deadline_us_ = now() + period_us_;
  const itimerspec grid{time_of(period_us_), time_of(deadline_us_)};
  ::timerfd_settime(timer_.get(), TFD_TIMER_ABSTIME, &grid, nullptr);
  service_manager_.notify("READY=1");
  messages_.put("ready: boat " + std::to_string(static_cast<int>(boat_->parameters().MAV_SYSID)) +
                " on " + config_.can);
  while (!stopping_) {
    wait();
    if (timer_fired_) tick();
  }
  shut_down();
  return 0;
}

void Loop::wait() {
  std::array<pollfd, 3 + app::kMaxLinks> waiting{};
  std::size_t count = 0;
  const auto wait_for = [&](int fd) { waiting[count++] = {fd, POLLIN, 0}; };
  wait_for(timer_.get());
  wait_for(signals_.get());
  wait_for(bus_->descriptor());
  for (const auto& link : links_) wait_for(link->descriptor());
  ::poll(waiting.data(), count, 1000);

  const std::int64_t woken_us = now();
  std::uint64_t expirations = 0;
  if (::read(timer_.get(), &expirations, sizeof expirations) > 0) {
    timer_fired_ = true;
    deadline_us_ += static_cast<std::int64_t>(expirations - 1) * period_us_;
    statistics_.overruns += static_cast<std::uint32_t>(expirations - 1);
    statistics_.lateness.add(woken_us - deadline_us_);
    deadline_us_ += period_us_;
  }
  // Nothing was read during missed ticks. The boat must judge the age of its data before it reads
  // the backlog, which would look new.
  if (expirations > 1) tick();
  const std::int64_t now_us = now();
  read_bus(now_us);
  read_links(now_us);
  signalfd_siginfo signal{};
  if (::read(signals_.get(), &signal, sizeof signal) > 0) stopping_ = true;
}

void Loop::read_bus(std::int64_t now_us) {
  link::CanFrame frame;
  for (int n = 0; n < kMaxFrames && bus_->receive(frame); ++n) {
    logs_.can(frame, clock_us(CLOCK_REALTIME));
    boat_->on_can(frame.id, frame.bytes(), now_us);
  }
}

void Loop::read_links(std::int64_t now_us) {
  std::array<std::uint8_t, 2048> buffer;
  // A flood must not stop the tick, nor may one link starve the others.
  const std::int64_t until_us = timer_fired_ ? now_us + kReadBeforeTick_us : deadline_us_;
  bool heard = true;
  for (int n = 0; heard && n < kMaxChunks && (n == 0 || now() < until_us); ++n) {
    heard = false;
    for (std::size_t i = 0; i < links_.size(); ++i) {
      const std::size_t size = links_[i]->receive(buffer);
      if (size == 0) continue;
      heard = true;
      const auto bytes = std::span(buffer).first(size);
      logs_.mavlink(i, Direction::kReceived, bytes, clock_us(CLOCK_REALTIME));
      boat_->on_mavlink(bytes, now_us, i);
      if (links_[i]->datagrams()) boat_->end_of_datagram(now_us, i);
      const app::Heard accepted = boat_->take_heard();
      if (accepted != app::Heard::kNothing) {
        links_[i]->accepted(accepted == app::Heard::kSigned, now_us);
      }
      if (heard_us_ == 0) heard_us_ = now_us;
    }
  }
}

/// The list whose last write failed; empty: none.
std::string_view Loop::unsaved_list() const {
  constexpr std::array<std::string_view, app::kStoredKinds> kNames{"plan", "fence", "rally points"};
  const auto failed =
      std::ranges::find_if(kept_, [](const Kept& kept) { return kept.saver.failed(); });
  return failed == kept_.end() ? std::string_view{}
                               : kNames[static_cast<std::size_t>(failed->kind)];
}

std::string_view Loop::why_not_to_arm() const {
  if (parameters_.must_be_confirmed()) return app::kParametersUnsaved;
  if (boat_->fence_is_lost()) return app::kFenceLost;
  const bool fence_unsaved = std::ranges::any_of(kept_, [](const Kept& kept) {
    return kept.kind == app::Stored::kFence && kept.saver.failed();
  });
  return fence_unsaved ? app::kFenceUnsaved : std::string_view{};
}

void Loop::tick() {
  timer_fired_ = false;
  const std::int64_t began_us = now();
  boat_->on_host({.bus_up = bus_->usable(),
                  .why_not_to_arm = why_not_to_arm(),
                  .overruns = statistics_.overruns,
                  .unix_us = clock_us(CLOCK_REALTIME),
                  .save_failed = parameters_.save_failed(),
                  .unsaved_list = unsaved_list(),
                  .stop_pressed = stop_.pressed(),
                  .closed_links = closed_links_,
                  .clock_is_set = !signing_time_ || signing_time_->clock_is_set()});
  if (signing_time_) signing_time_->put(boat_->signing_timestamp());
  send(boat_->tick(began_us), began_us);
  if (log_reader_) bring_logs();
  service_manager_.alive(began_us);
  if (began_us - house_kept_us_ >= kHouse_us) keep_house(began_us);
}

void Loop::send(const app::Boat<Scalar>::Output& out, std::int64_t now_us) {
  bus_->send(out.can);
  const std::int64_t sent_us = now();
  statistics_.processing.add(sent_us - now_us);
  if (heard_us_ != 0) statistics_.response.add(sent_us - heard_us_);
  heard_us_ = 0;
  const std::int64_t unix_us = clock_us(CLOCK_REALTIME);
  for (const link::CanFrame& frame : out.can) logs_.can(frame, unix_us);
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const auto bytes = out.links->bytes(i);
    if (bytes.empty()) continue;
    if (links_[i]->datagrams()) {
      each_datagram(bytes, [&](std::span<const std::uint8_t> one) { links_[i]->send(one); });
    } else {
      links_[i]->send(bytes);
    }
    logs_.mavlink(i, Direction::kSent, bytes, unix_us);
  }
}

void Loop::keep_house(std::int64_t now_us) {
  house_kept_us_ = now_us;
  maintain_devices(now_us);
  if (const auto error = logs_.error()) messages_.put(*error);
  if (const auto error = signing_time_ ? signing_time_->error() : std::nullopt) {
    messages_.put(*error);
  }
  if (const auto news =
          parameters_.maintain(boat_->take_save_request(), boat_->parameters(), now_us)) {
    messages_.put(*news);
  }
  keep_lists();
  for (Kept& kept : kept_) {
    if (const auto error = kept.saver.error()) messages_.put(*error);
  }
  if (const auto error = node_table_.error()) messages_.put(*error);
}

void Loop::bring_logs() {
  app::LogService& logs = boat_->logs();
  if (const auto answer = log_reader_->take()) {
    const LogReader::Request& asked = answer->request;
    const auto log = static_cast<std::uint16_t>(asked.log - (asked.list ? 0 : logs.left_out()));
    if (asked.list) {
      std::vector<app::StoredLog> list;
      for (const LogReader::Log& each : answer->logs) list.push_back({each.size, each.time_s});
      logs.bring_list(list);
    } else {
      logs.bring({false, log, asked.offset}, answer->bytes);
    }
  }
  if (const auto request = logs.request()) {
    log_reader_->ask(
        {request->list, request->log + logs.left_out(), request->offset, logs.piece_bytes()});
  }
}

void Loop::maintain_devices(std::int64_t now_us) {
  if (const int error = stop_.error(); std::exchange(stop_error_, error) != error) {
    messages_.put(
        "stop switch " + config_.stop.chip + ": " +
        (error == 0 ? "found" : std::string(std::strerror(error)) + ", counts as pressed"));
  }
  bus_->maintain();
  if (std::exchange(bus_usable_, bus_->usable()) != bus_usable_) {
    const std::string fault = bus_->fault();
    messages_.put(config_.can + (bus_usable_ ? " is up" : " is down or missing") +
                  (fault.empty() ? "" : ": " + fault));
  }
  for (std::size_t i = 0; i < links_.size(); ++i) {
    links_[i]->maintain(now_us);
    const bool open = links_[i]->descriptor() >= 0;
    const auto bit = static_cast<std::uint8_t>(1U << i);
    if (open == ((closed_links_ & bit) == 0)) continue;
    closed_links_ ^= bit;
    const std::string& address = config_.mavlink[i].address;
    const int error = links_[i]->error();
    messages_.put(address + (open ? " is open" : " is not open") +
                  (error == 0 ? std::string() : ": " + std::string(std::strerror(error))));
  }
}

void Loop::shut_down() {
  for (int i = 0; i < kFarewellTicks; ++i) {
    boat_->disarm();  // every time: the last message may have been a command to arm
    const std::int64_t now_us = now();
    read_bus(now_us);
    send(boat_->tick(now_us), now_us);
    const timespec next = time_of(now_us + period_us_);
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, nullptr);
  }
  service_manager_.notify("STOPPING=1");
  while (!keep_lists()) ::sched_yield();
  for (const std::string& news :
       parameters_.finish(boat_->take_save_request(), boat_->parameters())) {
    messages_.put(news);
  }
  if (signing_time_) signing_time_->put(boat_->signing_timestamp());
  if (config_.stats.empty()) return;
  if (const auto fault = write_statistics(config_.stats, statistics_, boat_->snapshot().counters,
                                          bus_->counters())) {
    messages_.put(*fault);
  }
}

}  // namespace flotilla::target
