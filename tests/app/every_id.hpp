// SPDX-License-Identifier: MIT
// Every message that a boat sends when it is asked for it, written out once more: none is lost
// unseen from the boat's own lists.
#pragma once

#include <array>
#include <cstdint>

#include "link/mavlink/mav.hpp"

namespace flotilla::testing {

inline constexpr std::array<std::uint16_t, 25> kEveryId{link::mav::kHeartbeatId,
                                                        link::mav::kSysStatusId,
                                                        link::mav::kSystemTimeId,
                                                        link::mav::kAttitudeId,
                                                        link::mav::kLocalPositionNedId,
                                                        link::mav::kGlobalPositionIntId,
                                                        link::mav::kGpsGlobalOriginId,
                                                        link::mav::kNavControllerOutputId,
                                                        link::mav::kPositionTargetLocalNedId,
                                                        link::mav::kFollowTargetId,
                                                        link::mav::kFormationReferenceId,
                                                        link::mav::kBatteryStatusId,
                                                        link::mav::kAutopilotVersionId,
                                                        link::mav::kHomePositionId,
                                                        link::mav::kMessageIntervalId,
                                                        link::mav::kExtendedSysStateId,
                                                        link::mav::kNamedValueFloatId,
                                                        link::mav::kEscInfoId,
                                                        link::mav::kEscStatusId,
                                                        link::mav::kProtocolVersionId,
                                                        link::mav::kOdometryId,
                                                        link::mav::kComponentInformationBasicId,
                                                        link::mav::kComponentMetadataId,
                                                        link::mav::kAvailableModesId,
                                                        link::mav::kCurrentModeId};

}  // namespace flotilla::testing
