// SPDX-License-Identifier: MIT
// Decides which telemetry is sent on which link, and how often.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "app/operator/mavlink_links.hpp"
#include "app/parameters/configuration.hpp"
#include "app/schedule.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::app {

enum class Pace : std::uint8_t {
  kState,      ///< SR_STATE
  kNews,       ///< twice SR_STATE, at most 10 Hz; news is sent up to half an interval early
  kSlow,       ///< SR_SLOW
  kFixed,      ///< as listed, or SR_SLOW if that is below 1 Hz
  kOnRequest,  ///< off until a client requests it with its own interval: SET_MESSAGE_INTERVAL
};

/// Whether streams of this pace share the bandwidth that state and news leave.
constexpr bool is_rest(Pace pace) { return pace != Pace::kState && pace != Pace::kNews; }

struct StreamInfo {
  std::uint16_t id;
  std::uint16_t bytes;  ///< greatest size on the wire
  Pace pace;
  std::int64_t fixed_us;
  bool companion;  ///< an autopilot's companion sends it too, as the autopilot itself never does
};

/// In sending order: first what followers need. Constants below hold indices: add at the end.
inline constexpr std::array kStreams{
    StreamInfo{link::GpsGlobalOrigin::kId, 32, Pace::kFixed, 1'000'000, false},
    StreamInfo{link::Attitude::kId, 40, Pace::kState, 0, false},
    StreamInfo{link::LocalPositionNed::kId, 40, Pace::kState, 0, false},
    StreamInfo{link::FormationReference::kId, 106, Pace::kNews, 0, true},
    StreamInfo{link::FollowTarget::kId, 105, Pace::kOnRequest, 0, false},
    StreamInfo{link::GlobalPositionInt::kId, 40, Pace::kFixed, 500'000, false},
    StreamInfo{link::SysStatus::kId, 43, Pace::kFixed, 1'000'000, false},
    StreamInfo{link::SystemTime::kId, 24, Pace::kFixed, 1'000'000, false},
    StreamInfo{link::CurrentMode::kId, 21, Pace::kOnRequest, 0, true},
    StreamInfo{link::MissionCurrent::kId, 43, Pace::kFixed, 1'000'000, false},
    StreamInfo{link::FenceStatus::kId, 21, Pace::kFixed, 1'000'000, false},
    StreamInfo{link::HomePosition::kId, 72, Pace::kFixed, 2'000'000, false},
    StreamInfo{link::NavControllerOutput::kId, 38, Pace::kSlow, 0, false},
    StreamInfo{link::PositionTargetLocalNed::kId, 63, Pace::kSlow, 0, false},
    StreamInfo{link::MavEscStatus::kId, 138, Pace::kOnRequest, 0, true},
    StreamInfo{link::MavEscInfo::kId, 116, Pace::kOnRequest, 0, true},
    StreamInfo{link::BatteryStatus::kId, 66, Pace::kFixed, 5'000'000, false},
    StreamInfo{link::NamedValueFloat::kId, 660, Pace::kSlow, 0, true},
    // Intervals other than 1 s, so that they do not stay in step with the streams above.
    StreamInfo{link::GpsRawInt::kId, 64, Pace::kFixed, 1'100'000, false},
    StreamInfo{link::VfrHud::kId, 32, Pace::kFixed, 900'000, false},
    StreamInfo{link::ExtendedSysState::kId, 14, Pace::kOnRequest, 0, false},
    StreamInfo{link::FormationFuture::kId, 74, Pace::kNews, 0, true},
};

constexpr std::size_t kOriginStream = 0, kPositionStream = 5, kPlanStream = 9, kFenceStream = 10,
                      kGpsStream = 18;
static_assert(kStreams[kPositionStream].id == link::GlobalPositionInt::kId);
static_assert(kStreams[kFenceStream].id == link::FenceStatus::kId);
static_assert(kStreams[kGpsStream].id == link::GpsRawInt::kId);
/// The state that followers need, at SR_STATE's pace.
constexpr std::array<std::size_t, 2> kStateStreams{1, 2};
constexpr std::size_t kReferenceStream = 3;
constexpr std::size_t kFutureStream = 21;
static_assert(kStreams[kReferenceStream].pace == Pace::kNews);
static_assert(kStreams[kFutureStream].pace == Pace::kNews);
static_assert(std::ranges::count(kStreams, Pace::kState, &StreamInfo::pace) == 2 &&
              kStreams[1].pace == Pace::kState && kStreams[2].pace == Pace::kState);

/// Whether a companion of an autopilot may send that message.
constexpr bool is_sent_by_companion(std::uint16_t id) {
  for (const StreamInfo& info : kStreams) {
    if (info.id == id) return info.companion;
  }
  return id != link::Odometry::kId;
}

/// Each link has its own intervals, which a client may change.
class Streams {
 public:
  struct Turn {
    std::int64_t desired_us = 0;
    Schedule schedule;
  };
  struct Link {
    std::array<Turn, kStreams.size()> turns{};
    std::int64_t radio_us = 0;  ///< last RADIO_STATUS
    double share = 1;           ///< of the full rate, as the radio allows
    bool narrow = false;        ///< carries at most as much as a radio of 57,600 Bd
    /// Earliest due time of the streams other than state and news; 0: recompute.
    std::int64_t quiet_until_us = 0;
  };

  /// links: one element for each link; must outlive this object.
  Streams(const Configuration& configuration, std::span<Link> links);

  /// Applies changed default rates.
  void configure(const Configuration::Operators& operators);

  /// A link that carries at most 5,760 bytes/s gets slow telemetry every 4 s, and the position every
  /// second: the rest of a radio of 57,600 Bd is for the other boats. 0: no limit.
  void limit(std::size_t link, std::uint32_t bytes_per_s);

  /// interval_us 0: the default, −1: never. An interval shorter than the tick, or than the link can
  /// carry (bytes_per_s, 0: no limit), is lengthened to that. False if there is no such stream.
  bool set(std::size_t link, std::uint16_t id, std::int64_t interval_us, std::uint32_t bytes_per_s);

  /// The effective interval of a fixed-pace stream: SR_SLOW below 1 Hz slows it too, so that
  /// parameters alone fit a fleet to a slow radio.
  std::int64_t slowed_us(std::size_t link, std::int64_t fixed_us) const;

  /// As in MESSAGE_INTERVAL: −1 if off, 0 if there is no such stream.
  std::int32_t interval_us(std::size_t link, std::uint16_t id) const;

  Schedule& schedule(std::size_t stream, std::size_t link) {
    return links_[link].turns[stream].schedule;
  }
  const Schedule& schedule(std::size_t stream, std::size_t link) const {
    return links_[link].turns[stream].schedule;
  }

  /// Whether any stream other than state and news is due on that link.
  bool any_rest_due(std::size_t link, std::int64_t now_us);

  /// Sends that message at once, on every link that carries it.
  void make_due(std::uint16_t id);

  /// Takes the radio's free send buffer in percent: streams slow down while it fills, the state
  /// streams only as far as followers tolerate. After 5 s of silence the radio no longer limits.
  void radio_has_room(std::size_t link, std::uint8_t percent, std::int64_t now_us);
  void forget_silent_radios(std::int64_t now_us);

 private:
  static constexpr std::size_t kNone = kStreams.size();

  std::size_t find(std::uint16_t id) const;
  std::int64_t plain_interval_us(std::size_t stream, std::size_t link) const;
  std::int64_t stretched_us(std::size_t stream, std::size_t link) const;
  std::int64_t slow_interval_us(std::size_t link) const;
  void restart(std::size_t stream, std::size_t link);
  void set_share(std::size_t link, double share);
  void look_anew(std::size_t link) { links_[link].quiet_until_us = 0; }

  bool companion_;
  bool configured_ = false;
  std::int64_t tick_us_;
  std::int64_t state_us_ = 0, slow_us_ = 0;
  std::span<Link> links_;
};

}  // namespace flotilla::app
