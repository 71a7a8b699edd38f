// SPDX-License-Identifier: MIT
// Messages about a boat's identity, capabilities and health.
#include <cstring>
#include <limits>

#include "link/mavlink/write.hpp"

namespace flotilla::link {
namespace {

constexpr std::uint8_t kUnknownStrength = 255;

}  // namespace

std::size_t MavlinkWriter::operator()(const RadioStatus& x) const {
  mavlink_radio_status_t w{};
  w.rssi = w.remrssi = w.noise = w.remnoise = kUnknownStrength;
  w.txbuf = x.txbuf;
  return put<MAVLINK_MSG_ID_RADIO_STATUS>(w);
}

std::size_t MavlinkWriter::operator()(const Statustext& x) const {
  mavlink_statustext_t w{};
  w.severity = x.severity;
  copy(w.text, x.text);
  w.id = x.id;
  w.chunk_seq = x.chunk_seq;
  return put<MAVLINK_MSG_ID_STATUSTEXT>(w);
}

std::size_t MavlinkWriter::operator()(const NamedValueFloat& x) const {
  mavlink_named_value_float_t w{};
  w.time_boot_ms = x.time_boot_ms;
  w.value = x.value;
  copy(w.name, x.name);
  return put<MAVLINK_MSG_ID_NAMED_VALUE_FLOAT>(w);
}

std::size_t MavlinkWriter::operator()(const SysStatus& x) const {
  mavlink_sys_status_t w{};
  w.onboard_control_sensors_present = x.sensors_present;
  w.onboard_control_sensors_enabled = x.sensors_enabled;
  w.onboard_control_sensors_health = x.sensors_health;
  w.load = x.load;
  w.voltage_battery = x.voltage_battery;
  w.current_battery = x.current_battery;
  w.battery_remaining = x.battery_remaining;
  return put<MAVLINK_MSG_ID_SYS_STATUS>(w);
}

std::size_t MavlinkWriter::operator()(const AutopilotVersion& x) const {
  mavlink_autopilot_version_t w{};
  w.capabilities = x.capabilities;
  w.uid = x.uid;
  w.flight_sw_version = x.flight_sw_version;
  copy(w.flight_custom_version, x.flight_custom_version);
  return put<MAVLINK_MSG_ID_AUTOPILOT_VERSION>(w);
}

std::size_t MavlinkWriter::operator()(const ProtocolVersion& x) const {
  mavlink_protocol_version_t w{};
  w.version = x.version;
  w.min_version = x.min_version;
  w.max_version = x.max_version;
  return put<MAVLINK_MSG_ID_PROTOCOL_VERSION>(w);
}

std::size_t MavlinkWriter::operator()(const ComponentInformationBasic& x) const {
  mavlink_component_information_basic_t w{};
  w.capabilities = x.capabilities;
  w.time_boot_ms = x.time_boot_ms;
  copy(w.vendor_name, x.vendor_name);
  copy(w.model_name, x.model_name);
  copy(w.software_version, x.software_version);
  return put<MAVLINK_MSG_ID_COMPONENT_INFORMATION_BASIC>(w);
}

std::size_t MavlinkWriter::operator()(const ComponentMetadata& x) const {
  mavlink_component_metadata_t w{};
  w.time_boot_ms = x.time_boot_ms;
  w.file_crc = x.file_crc;
  copy(w.uri, x.uri);
  return put<MAVLINK_MSG_ID_COMPONENT_METADATA>(w);
}

std::size_t MavlinkWriter::operator()(const AvailableModes& x) const {
  mavlink_available_modes_t w{};
  w.custom_mode = x.custom_mode;
  w.properties = x.properties;
  w.number_modes = x.number_modes;
  w.mode_index = x.mode_index;
  w.standard_mode = x.standard_mode;
  copy(w.mode_name, x.mode_name);
  return put<MAVLINK_MSG_ID_AVAILABLE_MODES>(w);
}

std::size_t MavlinkWriter::operator()(const CurrentMode& x) const {
  return put<MAVLINK_MSG_ID_CURRENT_MODE>(
      mavlink_current_mode_t{x.custom_mode, x.intended_custom_mode, x.standard_mode});
}

std::size_t MavlinkWriter::operator()(const MavEscInfo& x) const {
  mavlink_esc_info_t w{};
  w.time_usec = x.time_usec;
  copy(w.error_count, x.error_count);
  w.counter = x.counter;
  copy(w.temperature, x.temperature);
  w.index = x.index;
  w.count = x.count;
  w.connection_type = x.connection_type;
  w.info = x.info;
  return put<MAVLINK_MSG_ID_ESC_INFO>(w);
}

std::size_t MavlinkWriter::operator()(const MavEscStatus& x) const {
  mavlink_esc_status_t w{};
  w.time_usec = x.time_usec;
  copy(w.rpm, x.rpm);
  copy(w.voltage, x.voltage);
  copy(w.current, x.current);
  w.index = x.index;
  return put<MAVLINK_MSG_ID_ESC_STATUS>(w);
}

std::size_t MavlinkWriter::operator()(const BatteryStatus& x) const {
  mavlink_battery_status_t w{};
  w.current_consumed = -1;
  w.energy_consumed = -1;
  w.temperature = std::numeric_limits<std::int16_t>::max();
  std::memset(w.voltages, 0xFF, sizeof w.voltages);  // no measurement of single cells
  w.voltages[0] = x.voltage_mV;                      // all cells together
  w.current_battery = x.current_cA;
  w.battery_remaining = -1;
  return put<MAVLINK_MSG_ID_BATTERY_STATUS>(w);
}

}  // namespace flotilla::link
