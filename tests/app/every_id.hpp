// SPDX-License-Identifier: MIT
// Every message that a boat sends on request. It is a second list, so that a test notices a message
// that is missing from the boat's own lists.
#pragma once

#include <array>
#include <cstdint>

#include "link/mavlink/messages.hpp"

namespace flotilla::testing {

inline constexpr std::array<std::uint16_t, 29> kEveryId{link::Heartbeat::kId,
                                                        link::SysStatus::kId,
                                                        link::SystemTime::kId,
                                                        link::Attitude::kId,
                                                        link::LocalPositionNed::kId,
                                                        link::GlobalPositionInt::kId,
                                                        link::GpsGlobalOrigin::kId,
                                                        link::NavControllerOutput::kId,
                                                        link::PositionTargetLocalNed::kId,
                                                        link::FollowTarget::kId,
                                                        link::FormationReference::kId,
                                                        link::BatteryStatus::kId,
                                                        link::AutopilotVersion::kId,
                                                        link::HomePosition::kId,
                                                        link::MessageInterval::kId,
                                                        link::ExtendedSysState::kId,
                                                        link::NamedValueFloat::kId,
                                                        link::MavEscInfo::kId,
                                                        link::MavEscStatus::kId,
                                                        link::ProtocolVersion::kId,
                                                        link::Odometry::kId,
                                                        link::ComponentInformationBasic::kId,
                                                        link::ComponentMetadata::kId,
                                                        link::AvailableModes::kId,
                                                        link::CurrentMode::kId,
                                                        link::MissionCurrent::kId,
                                                        link::FenceStatus::kId,
                                                        link::GpsRawInt::kId,
                                                        link::VfrHud::kId};

}  // namespace flotilla::testing
