// SPDX-License-Identifier: MIT
// Numbers of the MAVLink protocol used by this firmware. Source: mavlink.io, common message set.
#pragma once

#include <cstdint>

namespace flotilla::link::mav {

constexpr std::uint8_t kTypeGeneric = 0, kTypeGcs = 6, kTypeSurfaceBoat = 11,
                       kTypeOnboardController = 18;
constexpr std::uint8_t kAutopilotGeneric = 0, kAutopilotArdupilot = 3, kAutopilotInvalid = 8;
constexpr std::uint8_t kComponentAutopilot = 1, kComponentRadio = 68;
constexpr std::uint8_t kModeFlagCustom = 1, kModeFlagTest = 2, kModeFlagAuto = 4,
                       kModeFlagGuided = 8, kModeFlagManual = 64, kModeFlagArmed = 128;
constexpr std::uint8_t kStateStandby = 3, kStateActive = 4, kStateCritical = 5, kStateEmergency = 6;
constexpr std::uint8_t kFrameGlobal = 0, kFrameLocalNed = 1, kFrameLocalEnu = 4, kFrameBodyNed = 8,
                       kFrameBodyOffsetNed = 9, kFrameBodyFrd = 12;
constexpr std::uint16_t kAisCourse = 2, kAisSpeed = 4, kAisFast = 8, kAisDimensions = 64;
constexpr std::uint8_t kAisAnchored = 1, kAisMoored = 5, kAisAground = 6;
constexpr std::uint8_t kFollowPosition = 1, kFollowVelocity = 2, kFollowAcceleration = 4,
                       kFollowAttitude = 8;

/// FORMATION_REFERENCE's flags.
constexpr std::uint8_t kReferenceFollowed = 1, kReferenceUntimed = 2;

constexpr std::uint16_t kCmdDoSetMode = 176, kCmdDoFlightTermination = 185, kCmdDoMotorTest = 209,
                        kCmdNavReturnToLaunch = 20, kCmdDoReposition = 192,
                        kCmdDoPauseContinue = 193, kCmdDoFenceEnable = 207,
                        kCmdDoSetMissionCurrent = 224, kCmdMissionStart = 300,
                        kCmdPreflightStorage = 245, kCmdDoSetStandardMode = 262,
                        kCmdComponentArmDisarm = 400, kCmdGetHomePosition = 410,
                        kCmdInjectFailure = 420, kCmdGetMessageInterval = 510,
                        kCmdSetMessageInterval = 511, kCmdRequestMessage = 512,
                        kCmdRequestProtocolVersion = 519, kCmdRequestAutopilotCapabilities = 520;
constexpr std::uint8_t kAccepted = 0, kTemporarilyRejected = 1, kDenied = 2, kUnsupported = 3,
                       kFailed = 4, kCommandIntOnly = 8, kUnsupportedFrame = 9;

constexpr std::uint8_t kParamReal32 = 9;
constexpr std::uint8_t kParamDoesNotExist = 1, kParamOutOfRange = 2, kParamPermissionDenied = 3,
                       kParamTypeMismatch = 7;
constexpr std::uint8_t kMissionAccepted = 0, kMissionUnsupportedFrame = 2, kMissionUnsupported = 3,
                       kMissionNoSpace = 4, kMissionInvalid = 5, kMissionInvalidParam1 = 6,
                       kMissionInvalidParam2 = 7, kMissionInvalidParam3 = 8, kMissionInvalidX = 10,
                       kMissionInvalidY = 11, kMissionInvalidSequence = 13, kMissionDenied = 14,
                       kMissionCancelled = 15;
constexpr std::uint8_t kMissionTypePlan = 0, kMissionTypeFence = 1, kMissionTypeRally = 2,
                       kMissionTypeAll = 255;
/// MAV_STANDARD_MODE.
constexpr std::uint8_t kStandardModeSafeRecovery = 5, kStandardModeMission = 6;
/// MISSION_STATE.
constexpr std::uint8_t kMissionNotStarted = 2, kMissionActive = 3, kMissionPaused = 4,
                       kMissionComplete = 5;
/// Commands in plans.
constexpr std::uint16_t kNavWaypoint = 16, kNavLoiterUnlimited = 17, kNavLoiterTurns = 18,
                        kNavLoiterTime = 19, kNavReturn = 20, kNavDelay = 93, kConditionDelay = 112,
                        kDoJump = 177, kDoChangeSpeed = 178, kDoSetHome = 179, kDoSetRoi = 201,
                        kVoyage = 31010;  // MAV_CMD_USER_1
/// Items of fences, and of rally points.
constexpr std::uint16_t kFenceReturnPoint = 5000, kFenceInclusion = 5001, kFenceExclusion = 5002,
                        kFenceCircleInclusion = 5003, kFenceCircleExclusion = 5004,
                        kRallyPoint = 5100;
/// FENCE_BREACH.
constexpr std::uint8_t kBreachNone = 0, kBreachBoundary = 3;
/// FENCE_TYPE.
constexpr std::uint32_t kFencePolygon = 4;

constexpr std::uint64_t kCapabilityMissionInt = 4, kCapabilityCommandInt = 8,
                        kCapabilityParamBytewise = 16, kCapabilityFtp = 32,
                        kCapabilityMavlink2 = 8192, kCapabilityMissionFence = 16384,
                        kCapabilityMissionRally = 32768;
constexpr std::uint32_t kModePropertyNotUserSelectable = 2, kModePropertyAuto = 4;

constexpr std::uint32_t kSensorGyro = 1, kSensorAccel = 2, kSensorMag = 4, kSensorGps = 32,
                        kSensorPositionControl = 0x4000, kSensorMotors = 0x8000,
                        kSensorRcReceiver = 0x10000, kSensorGeofence = 0x100000,
                        kSensorAhrs = 0x200000, kSensorBattery = 0x2000000,
                        kSensorPrearm = 0x10000000, kSensorPropulsion = 0x40000000;

constexpr std::uint8_t kSeverityCritical = 2, kSeverityError = 3, kSeverityWarning = 4,
                       kSeverityInfo = 6;

constexpr std::uint32_t kSetupSigningId = 256;

}  // namespace flotilla::link::mav
