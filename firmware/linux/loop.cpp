// SPDX-License-Identifier: MIT
#include "linux/loop.hpp"

#include <poll.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/signalfd.h>
#include <sys/timerfd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "linux/datagrams.hpp"
#include "linux/signing_key.hpp"

namespace flotilla::target {
namespace {

constexpr std::int64_t kSecond_us = 1'000'000;
constexpr std::int64_t kHouse_us = 100'000;
// Minimum interval of saves: not every step of a slider goes to the disk.
constexpr std::int64_t kSaveEvery_us = kSecond_us;
constexpr int kFarewellTicks = 10;
// A stored signing timestamp further ahead of the clock than this is reported.
constexpr std::uint64_t kStampsPerSecond = 100'000, kWorthSaying = 60 * kStampsPerSecond;
// Read at once; the timer is checked before the rest: a flood must not stop the tick.
constexpr int kMaxFrames = 256, kMaxChunks = 64;
constexpr std::int64_t kReadBeforeTick_us = 1000;

std::int64_t clock_us(clockid_t clock) {
  timespec t{};
  ::clock_gettime(clock, &t);
  return std::int64_t{t.tv_sec} * kSecond_us + t.tv_nsec / 1000;
}

std::int64_t now() { return clock_us(CLOCK_MONOTONIC); }

void print_line(std::string_view text) {
  std::fprintf(stderr, "flotillad: %.*s\n", static_cast<int>(text.size()), text.data());
}

timespec time_of(std::int64_t us) { return {us / kSecond_us, us % kSecond_us * 1000}; }

/// Real-time priority and locked memory are optional: without them the boat sails and reports it.
void ask_for_real_time(const Config& config) {
  if (config.priority > 0) {
    sched_param wish{};
    wish.sched_priority = config.priority;
    if (::sched_setscheduler(0, SCHED_FIFO, &wish) != 0) {
      print_line("SCHED_FIFO refused (" + std::string(std::strerror(errno)) +
                 "): ordinary priority");
    }
  }
  if (config.lock_memory && ::mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
    print_line("locked memory refused (" + std::string(std::strerror(errno)) +
               "): memory may be paged");
  }
}

FileDescriptor catch_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGHUP);  // the terminal has closed
  ::sigprocmask(SIG_BLOCK, &set, nullptr);
  ::signal(SIGPIPE, SIG_IGN);  // the reader of our messages may end; we go on
  return FileDescriptor(::signalfd(-1, &set, SFD_NONBLOCK | SFD_CLOEXEC));
}

void make_directory(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) throw std::runtime_error("state-dir " + path.string() + ": " + error.message());
}

LoadedParameters load(const Config& config) {
  make_directory(config.state_dir);
  LoadedParameters loaded = load_parameters(config.parameter_file());
  for (const std::string& note : loaded.notes) print_line(note);
  return loaded;
}

/// The parameters in force: the saved ones, overridden by the configuration.
app::Parameters in_force(const Config& config, const LoadedParameters& loaded) {
  app::Parameters values = loaded.values;
  apply(config.param, values);
  if (const auto sentence = app::contradiction(values)) {
    throw std::runtime_error(std::string(*sentence));
  }
  return values;
}

}  // namespace

Loop::Loop(const Config& config)
    : config_(config),
      parameters_(load(config)),
      boat_(std::make_unique<app::Boat<Scalar>>(in_force(config, parameters_),
                                                config.mavlink.size())),
      noted_(boat_->parameters()),
      saver_(config.parameter_file(), parameters_.unknown),
      bus_(open_can_bus(config.can, static_cast<std::uint8_t>(boat_->parameters().CAN_NODE))),
      node_table_(config.node_id_file()),
      logs_({config.log, candump_name(config.can)}),
      timer_(::timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC)),
      signals_(catch_signals()),
      period_us_(static_cast<std::int64_t>(1e6 / double{boat_->parameters().CTL_RATE} + 0.5)) {
  for (std::size_t i = 0; i < config.mavlink.size(); ++i) {
    links_.push_back(open_mavlink_endpoint(config.mavlink[i].address));
    boat_->limit_link(i, config.mavlink[i].bytes_per_s);
    boat_->set_policy(i, config.policy(config.mavlink[i]));
  }
  if (!config.signing_key.empty()) secure();
  node_table_.load(boat_->node_ids());
}

void Loop::secure() {
  const link::SigningKey key = read_signing_key(config_.signing_key);
  const StoredSigningTime stored = load_signing_time(config_.signing_time_file());
  if (!stored.note.empty()) print_line(stored.note);
  const std::uint64_t clock = link::signing_time(clock_us(CLOCK_REALTIME));
  if (stored.timestamp > clock + kWorthSaying) {
    print_line("the clock is " + std::to_string((stored.timestamp - clock) / kStampsPerSecond) +
               " s behind " + config_.signing_time_file().filename().string() +
               ": who signs by another clock may be refused");
  }
  boat_->secure(key, clock, stored.timestamp);
  signing_time_.emplace(config_.signing_time_file(), boat_->signing_timestamp());
}

int Loop::run() {
  ask_for_real_time(config_);
  deadline_us_ = now() + period_us_;
  const itimerspec grid{time_of(period_us_), time_of(deadline_us_)};
  ::timerfd_settime(timer_.get(), TFD_TIMER_ABSTIME, &grid, nullptr);
  service_manager_.notify("READY=1");
  print_line("ready: boat " + std::to_string(static_cast<int>(boat_->parameters().MAV_SYSID)) +
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
    overruns_ += static_cast<std::uint32_t>(expirations - 1);
    lateness_.add(woken_us - deadline_us_);
    deadline_us_ += period_us_;
  }
  // Nothing was read during missed ticks: the boat must judge the age of its data before the
  // backlog passes for new.
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
      if (heard_us_ == 0) heard_us_ = now_us;
    }
  }
}

void Loop::tick() {
  timer_fired_ = false;
  const std::int64_t began_us = now();
  boat_->on_host({bus_->usable(), !parameters_.must_be_confirmed, overruns_,
                  clock_us(CLOCK_REALTIME), save_failed_});
  if (signing_time_) signing_time_->put(boat_->signing_timestamp());
  send(boat_->tick(began_us), began_us);
  service_manager_.alive(began_us);
  if (began_us - house_kept_us_ >= kHouse_us) keep_house(began_us);
}

void Loop::send(const app::Boat<Scalar>::Output& out, std::int64_t now_us) {
  bus_->send(out.can);
  const std::int64_t sent_us = now();
  processing_.add(sent_us - now_us);
  if (heard_us_ != 0) response_.add(sent_us - heard_us_);
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
  bus_->maintain();
  if (std::exchange(bus_usable_, bus_->usable()) != bus_usable_) {
    print_line(config_.can + (bus_usable_ ? " is up" : " is down or not there"));
  }
  for (const auto& link : links_) link->maintain();
  if (const auto complaint = logs_.complaint()) print_line(*complaint);
  if (const auto complaint = signing_time_ ? signing_time_->complaint() : std::nullopt) {
    print_line(*complaint);
  }
  report_outcome();
  note_changes();
  save_changes(now_us);
  // Disk writes may block, so an armed boat does not start them.
  if (core::armed(boat_->state())) return;
  if (const std::string error = node_table_.save_if_changed(boat_->node_ids()); !error.empty()) {
    print_line(error);
  }
}

/// Marks the operator's changes since the last call for saving. Overrides by the configuration are
/// not saved unless the operator asks to save all parameters in force.
void Loop::note_changes() {
  const app::SaveRequest request = boat_->take_save_request();
  if (request == app::SaveRequest::kNone) return;
  const app::Parameters& values = boat_->parameters();
  app::Parameters& saved = parameters_.values;
  for (const app::ParameterInfo& info : app::kParameterList) {
    if (values.*info.member != noted_.*info.member) saved.*info.member = values.*info.member;
  }
  if (request == app::SaveRequest::kConfirmed || app::contradiction(saved)) saved = values;
  noted_ = values;
  to_save_ = std::max(to_save_, request);
}

void Loop::save_changes(std::int64_t now_us) {
  using app::SaveRequest;
  if (to_save_ == SaveRequest::kNone) return;
  // After a fall-back to defaults, an operator must confirm them before they are saved.
  const bool unasked = to_save_ == SaveRequest::kChanged;
  if (unasked && parameters_.must_be_confirmed) return;
  if ((unasked || save_failed_) && now_us - saved_us_ < kSaveEvery_us) return;
  if (!saver_.save(parameters_.values, to_save_)) return;
  to_save_ = SaveRequest::kNone;
  saved_us_ = now_us;
}

void Loop::report_outcome() {
  const auto saved = saver_.outcome();
  if (!saved) return;
  if (saved->fault) to_save_ = std::max(to_save_, saved->why);  // to be retried
  const bool asked = saved->why == app::SaveRequest::kConfirmed;
  report_saved(asked ? "asked for" : "changed", saved->fault);
}

void Loop::report_saved(std::string_view why, const std::optional<std::string>& fault) {
  const bool failed_before = std::exchange(save_failed_, fault.has_value());
  if (fault) {
    if (!failed_before) print_line(*fault);
    return;
  }
  parameters_.must_be_confirmed = false;
  print_line("parameters saved (" + std::string(why) + ")");
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
  saver_.finish();
  report_outcome();
  note_changes();
  if (!parameters_.must_be_confirmed || to_save_ == app::SaveRequest::kConfirmed) {
    report_saved("at exit", save_parameters(config_.parameter_file(), parameters_.values,
                                            parameters_.unknown));
  }
  if (const std::string error = node_table_.save_if_changed(boat_->node_ids()); !error.empty()) {
    print_line(error);
  }
  if (signing_time_) signing_time_->put(boat_->signing_timestamp());
  write_stats();
}

void Loop::write_stats() const {
  if (config_.stats.empty()) return;
  std::FILE* file = std::fopen(config_.stats.c_str(), "w");
  if (file == nullptr) {
    print_line("stats " + config_.stats.string() + ": " + std::strerror(errno));
    return;
  }
  const auto put = [&](const char* name, const Latency& latency) {
    std::fprintf(file,
                 "  \"%s_us\": {\"p50\": %lld, \"p99\": %lld, \"p99.9\": %lld, \"max\": %lld},\n",
                 name, static_cast<long long>(latency.percentile_us(0.5)),
                 static_cast<long long>(latency.percentile_us(0.99)),
                 static_cast<long long>(latency.percentile_us(0.999)),
                 static_cast<long long>(latency.greatest_us()));
  };
  const CanBusCounters& can = bus_->counters();
  std::fprintf(file, "{\n");
  put("lateness", lateness_);
  put("processing", processing_);
  put("response", response_);
  std::fprintf(file, "  \"ticks\": %llu, \"overruns\": %u,\n",
               static_cast<unsigned long long>(lateness_.count()), overruns_);
  const link::Counters mavlink = boat_->snapshot().counters;
  std::fprintf(file,
               "  \"mavlink\": {\"received\": %u, \"bad_checksum\": %u, \"signed\": %u, "
               "\"forged\": %u, \"replayed\": %u, \"future_stamp\": %u, "
               "\"unsigned_refused\": %u},\n",
               mavlink.mavlink_received, mavlink.mavlink_bad_checksum, mavlink.mavlink_signed,
               mavlink.mavlink_forged, mavlink.mavlink_replayed, mavlink.mavlink_future_stamp,
               mavlink.mavlink_unsigned_refused);
  std::fprintf(
      file,
      "  \"can\": {\"sent\": %llu, \"received\": %llu, \"transfers_dropped\": %llu, "
      "\"receive_overflows\": %llu, \"error_frames\": %llu, \"bus_off\": %llu, "
      "\"reopened\": %llu, \"bad_packets\": %llu}\n}\n",
      static_cast<unsigned long long>(can.sent), static_cast<unsigned long long>(can.received),
      static_cast<unsigned long long>(can.transfers_dropped),
      static_cast<unsigned long long>(can.receive_overflows),
      static_cast<unsigned long long>(can.error_frames),
      static_cast<unsigned long long>(can.bus_off), static_cast<unsigned long long>(can.reopened),
      static_cast<unsigned long long>(can.bad_packets));
  std::fclose(file);
}

}  // namespace flotilla::target
