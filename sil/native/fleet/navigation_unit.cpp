// SPDX-License-Identifier: MIT
#include "fleet/navigation_unit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "link/mavlink/mav.hpp"

namespace flotilla::fleet {
namespace {

constexpr MessageType kHeartbeat{0, 50}, kGpsRawInt{24, 24}, kAttitude{30, 39},
    kLocalPositionNed{32, 185}, kGlobalPositionInt{33, 104}, kGpsGlobalOrigin{49, 39},
    kRcChannels{65, 118}, kTimesync{111, 34}, kFollowTarget{144, 127}, kEstimatorStatus{230, 163},
    kOdometry{331, 91};
constexpr std::uint8_t kEstimatorGpsIns = 5, kMavlinkVersion = 3;
constexpr std::uint16_t kUnknownHeading = 65535;

std::int64_t whole_us(double s) { return static_cast<std::int64_t>(std::nearbyint(1e6 * s)); }

std::uint32_t boot_ms(std::int64_t now_us) { return static_cast<std::uint32_t>(now_us / 1000); }

float single(double x) { return static_cast<float>(x); }

/// ψ in (−π, π].
double wrap(double psi) {
  constexpr double kPi = std::numbers::pi;
  if (-kPi < psi && psi <= kPi) return psi;
  const double wrapped = std::remainder(psi, 2 * kPi);
  return wrapped <= -kPi ? kPi : wrapped;
}

/// The quaternion w, 0, 0, z of a heading.
std::array<float, 4> quaternion(double psi) {
  const double half = 0.5 * wrap(psi);
  return {single(std::cos(half)), 0, 0, single(std::sin(half))};
}

struct NorthEast {
  double north, east;
};

NorthEast velocity(const Sensed& s) {
  const double c = std::cos(s.eta[2]), n = std::sin(s.eta[2]);
  return {c * s.nu[0] - n * s.nu[1], n * s.nu[0] + c * s.nu[1]};
}

/// NaN, a body without a velocity, gives 0.
std::int16_t cm_per_s(double mps) {
  if (std::isnan(mps)) return 0;
  return static_cast<std::int16_t>(std::clamp(std::nearbyint(100.0 * mps), -32768.0, 32767.0));
}

/// MAVLink's encoding of an unknown covariance.
std::array<float, 21> unknown_covariance() { return {std::numeric_limits<float>::quiet_NaN()}; }

}  // namespace

NavigationUnit::NavigationUnit(link::Address self, const UnitSettings& settings)
    : self_(self),
      settings_(settings),
      writer_(self),
      state_rate_(settings.rate_hz),
      slow_rate_(1.0),
      delay_us_(whole_us(settings.delay_s)),
      every_us_(whole_us(settings.dropout_every_s)),
      dropout_us_(whole_us(settings.dropout_s)) {
  if (settings.attitude_rate_hz > 0) attitude_rate_.emplace(settings.attitude_rate_hz);
}

void NavigationUnit::tick(std::int64_t now_us, const Sensed& sensed, Out& out) {
  if (delay_us_ == 0) {
    if (slow_rate_.due(now_us)) tell_slowly(now_us, out);
    answer(out);
    return tell_due(now_us, sensed, out);
  }
  Waiting& next = waiting_.emplace_back(now_us, Out{});
  if (slow_rate_.due(now_us)) tell_slowly(now_us, next.frames);
  tell_due(now_us, sensed, next.frames);
  answer(out);
  // A clock that went back delays nothing further.
  const auto waits = [&](std::int64_t since_us) {
    return since_us <= now_us && now_us - since_us < delay_us_;
  };
  for (; !waiting_.empty() && !waits(waiting_.front().since_us); waiting_.erase(waiting_.begin())) {
    const Out& frames = waiting_.front().frames;
    out.insert(out.end(), frames.begin(), frames.end());
  }
}

void NavigationUnit::answer(Out& out) {
  for (const Request& request : requests_) {
    // The instant of reading, not of answering: the requester bounds our clock by it.
    writer_.write(out, kTimesync, 1000 * request.arrived_us, request.ts1_ns);
  }
  requests_.clear();
}

/// Sends the state if due; nothing during a drop-out.
void NavigationUnit::tell_due(std::int64_t now_us, const Sensed& sensed, Out& out) {
  const bool attitude_due = attitude_rate_ && attitude_rate_->due(now_us);
  const bool state_due = state_rate_.due(now_us);
  if (faulty_ && faulty_->pilot && faulty_->pilot_rate.due(now_us)) pilot(now_us, out);
  if (drops_out(now_us)) return;
  if (faulty_ && (faulty_->fix || faulty_->accuracy_m) && faulty_->fix_rate.due(now_us)) {
    if (faulty_->fix) fix(now_us, out);
    if (faulty_->accuracy_m) estimate(now_us, out);
  }
  if (attitude_due) attitude(now_us, sensed, out);
  if (state_due) tell(now_us, sensed, out);
}

bool NavigationUnit::drops_out(std::int64_t now_us) const {
  return every_us_ > 0 && now_us % every_us_ >= every_us_ - dropout_us_;
}

void NavigationUnit::tell_slowly(std::int64_t now_us, Out& out) {
  using namespace link::mav;
  const bool vehicle = settings_.vehicle;
  writer_.write(out, kHeartbeat, std::uint32_t{0}, vehicle ? kTypeSurfaceBoat : kTypeGeneric,
                vehicle ? kAutopilotGeneric : kAutopilotInvalid, std::uint8_t{0}, kStateActive,
                kMavlinkVersion);
  writer_.write(out, kGpsGlobalOrigin, settings_.origin, now_us);
}

void NavigationUnit::tell(std::int64_t now_us, const Sensed& sensed, Out& out) {
  switch (settings_.message) {
    case StateMessage::kLocal:
      return local(now_us, sensed, out);
    case StateMessage::kOdometry:
      return odometry(now_us, sensed, out);
    case StateMessage::kGlobal:
      return global(now_us, sensed, out);
    case StateMessage::kFollowTarget:
      return follow_target(now_us, sensed, out);
  }
}

void NavigationUnit::attitude(std::int64_t now_us, const Sensed& s, Out& out) {
  writer_.write(out, kAttitude, boot_ms(now_us), 0.0F, 0.0F, single(wrap(s.eta[2])), 0.0F, 0.0F,
                single(s.nu[2]));
}

void NavigationUnit::local(std::int64_t now_us, const Sensed& s, Out& out) {
  if (!attitude_rate_) attitude(now_us, s, out);
  const auto [north, east] = velocity(s);
  writer_.write(out, kLocalPositionNed, boot_ms(now_us), single(s.eta[0]), single(s.eta[1]), 0.0F,
                single(north), single(east), 0.0F);
}

void NavigationUnit::odometry(std::int64_t now_us, const Sensed& s, Out& out) {
  writer_.write(out, kOdometry, now_us, single(s.eta[0]), single(s.eta[1]), 0.0F,
                quaternion(s.eta[2]), single(s.nu[0]), single(s.nu[1]), 0.0F, 0.0F, 0.0F,
                single(s.nu[2]), unknown_covariance(), unknown_covariance(),
                link::mav::kFrameLocalNed, link::mav::kFrameBodyFrd, std::uint8_t{0},
                kEstimatorGpsIns, std::int8_t{0});
}

void NavigationUnit::global(std::int64_t now_us, const Sensed& s, Out& out) {
  if (!attitude_rate_) attitude(now_us, s, out);
  const auto [north, east] = velocity(s);
  writer_.write(out, kGlobalPositionInt, boot_ms(now_us), s.degE7, settings_.origin[2],
                std::int32_t{0}, cm_per_s(north), cm_per_s(east), std::int16_t{0}, kUnknownHeading);
}

void NavigationUnit::follow_target(std::int64_t now_us, const Sensed& s, Out& out) {
  using link::mav::kFollowAttitude, link::mav::kFollowPosition, link::mav::kFollowVelocity;
  const auto [north, east] = velocity(s);
  const std::array<float, 3> zeros{}, rates{0, 0, single(s.nu[2])};
  writer_.write(out, kFollowTarget, now_us / 1000, std::uint64_t{0}, s.degE7,
                single(0.001 * settings_.origin[2]), std::array{single(north), single(east), 0.0F},
                zeros, quaternion(s.eta[2]), rates, zeros,
                static_cast<std::uint8_t>(kFollowPosition | kFollowVelocity | kFollowAttitude));
}

NavigationUnit::Faulty& NavigationUnit::faulty() {
  if (!faulty_) faulty_ = std::make_unique<Faulty>();
  return *faulty_;
}

void NavigationUnit::fix(std::int64_t now_us, Out& out) {
  const bool good = *faulty_->fix;
  constexpr std::uint8_t kNoFix = 1, kFix3d = 3;
  constexpr std::uint16_t kUnknown = 65535, kHdop = 80;  // 0.8
  writer_.write(out, kGpsRawInt, now_us, settings_.origin, good ? kHdop : kUnknown, kUnknown,
                kUnknown, kUnknown, good ? kFix3d : kNoFix,
                static_cast<std::uint8_t>(good ? 14 : 0));
}

void NavigationUnit::estimate(std::int64_t now_us, Out& out) {
  constexpr std::uint16_t kFlags = 0x3F;  // attitude, velocities, positions
  constexpr std::array<float, 6> kRatios{0.1F, 0.1F, 0.1F, 0.1F, 0.1F, 0.1F};
  float& accuracy_m = *faulty_->accuracy_m;
  writer_.write(out, kEstimatorStatus, now_us, kRatios, accuracy_m, accuracy_m, kFlags);
  if (accuracy_m == kPoor_m) accuracy_m = std::numeric_limits<float>::quiet_NaN();
}

void NavigationUnit::pilot(std::int64_t now_us, Out& out) {
  const std::optional<double> throttle = faulty_->pilot->throttle;
  constexpr std::uint8_t kChannels = 16, kThrottle = 2, kFirstSwitch = 4, kRssiUnknown = 255;
  std::array<std::uint16_t, 18> pulses_us{};
  std::fill_n(pulses_us.begin(), kFirstSwitch, std::uint16_t{1500});
  std::fill_n(pulses_us.begin() + kFirstSwitch, kChannels - kFirstSwitch,
              static_cast<std::uint16_t>(throttle ? 1900 : 1100));
  pulses_us[kThrottle] = static_cast<std::uint16_t>(1500 + std::lround(400 * throttle.value_or(0)));
  writer_.write(out, kRcChannels, boot_ms(now_us), pulses_us, kChannels, kRssiUnknown);
}

// Splits by the frames' length bytes. After bytes that are no frame, lengths are not trusted: any
// start byte may begin a frame, so garbage cannot hide a frame behind it.
void NavigationUnit::on_mavlink(std::span<const std::uint8_t> data, std::int64_t now_us) {
  const auto next = [&](std::size_t from) {
    if (from < data.size() && data[from] == link::kStart2) return from;
    const auto begin = data.begin() + static_cast<std::ptrdiff_t>(std::min(from, data.size()));
    return static_cast<std::size_t>(std::find(begin, data.end(), link::kStart2) - data.begin());
  };
  std::size_t at = next(0);
  bool clean = at == 0;
  while (const auto header = link::read_header(data.subspan(at))) {
    const std::size_t end = at + header->frame_bytes();
    const bool whole = end <= data.size() && header->is_known();
    if (whole && header->id == kTimesync.id && settings_.timesync)
      take_timesync(data.subspan(at, end - at), *header, now_us);
    clean = clean && whole && (end == data.size() || data[end] == link::kStart2);
    at = next(clean ? end : at + 1);
  }
}

void NavigationUnit::take_timesync(std::span<const std::uint8_t> frame,
                                   const link::FrameHeader& header, std::int64_t now_us) {
  if (!link::checksum_is_good(frame, header, kTimesync.crc_extra)) return;
  struct {
    std::int64_t tc1, ts1;
    std::uint8_t system, component;  // the target, 0: all; an extension of upstream
  } asked{};
  std::memcpy(&asked, frame.data() + header.header_bytes,
              std::min<std::size_t>(header.payload_bytes, 18));
  const bool for_us = (asked.system == 0 || asked.system == self_.system) &&
                      (asked.component == 0 || asked.component == self_.component);
  if (asked.tc1 == 0 && for_us) requests_.push_back({asked.ts1, now_us});
}

}  // namespace flotilla::fleet
