// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <random>

#include "link/dronecan/messages.hpp"
#include "link/dronecan_vectors.hpp"

namespace flotilla::link {
namespace {

using vectors::Bytes;
using vectors::bytes_of;

template <class Message>
Bytes written(const Message& message) {
  Payload out;
  out.fill(0xA5);  // earlier contents must not remain
  const std::size_t size = write_payload(message, out);
  return {out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size)};
}

void check_same(double got, double expected) {
  if (std::isnan(expected)) {
    CHECK(std::isnan(got));
  } else if (std::isinf(expected)) {
    CHECK(std::abs(got) == 65504);  // the vectors' sender saturates infinity
  } else {
    CHECK(got == doctest::Approx(expected).epsilon(1e-3));  // float16 has 11 bits
  }
}

TEST_CASE("every RawCommand of the test vectors is decoded and encoded exactly") {
  for (const vectors::Values& v : vectors::kRawCommands) {
    CAPTURE(v.payload);
    const auto message = read_raw_command(bytes_of(v.payload));
    REQUIRE(message);
    REQUIRE(message->count == v.values.size());
    for (std::size_t i = 0; i < v.values.size(); ++i) CHECK(message->cmd[i] == v.values[i]);
    CHECK(written(*message) == bytes_of(v.payload));
  }
}

TEST_CASE("every esc.Status of the test vectors is decoded and encoded exactly") {
  for (const vectors::Values& v : vectors::kEscStatuses) {
    CAPTURE(v.payload);
    const auto message = read_esc_status(bytes_of(v.payload));
    REQUIRE(message);
    CHECK(message->error_count == v.values[0]);
    check_same(double{message->voltage}, v.values[1]);
    check_same(double{message->current}, v.values[2]);
    check_same(double{message->temperature}, v.values[3]);
    CHECK(message->rpm == v.values[4]);
    CHECK(message->power_rating_pct == v.values[5]);
    CHECK(message->esc_index == v.values[6]);
    CHECK(written(*message) == bytes_of(v.payload));
  }
}

TEST_CASE("every NodeStatus and ArmingStatus of the test vectors is decoded and encoded exactly") {
  for (const vectors::Values& v : vectors::kNodeStatuses) {
    CAPTURE(v.payload);
    const auto message = read_node_status(bytes_of(v.payload));
    REQUIRE(message);
    CHECK(message->uptime_sec == v.values[0]);
    CHECK(message->health == v.values[1]);
    CHECK(message->mode == v.values[2]);
    CHECK(message->sub_mode == v.values[3]);
    CHECK(message->vendor_specific_status_code == v.values[4]);
    CHECK(written(*message) == bytes_of(v.payload));
  }
  for (const vectors::Values& v : vectors::kArmingStatuses) {
    const auto message = read_arming_status(bytes_of(v.payload));
    REQUIRE(message);
    CHECK(message->status == v.values[0]);
    CHECK(written(*message) == bytes_of(v.payload));
  }
}

TEST_CASE("the captured GetNodeInfo answer is written from its values") {
  NodeInfo info;
  info.status.uptime_sec = 4;
  info.software_major = 1;
  info.software_minor = 2;
  info.vcs_commit = 0xDEADBEEF;
  info.hardware_major = 3;
  info.hardware_minor = 4;
  for (std::uint8_t i = 0; i < 16; ++i) info.unique_id[i] = static_cast<std::uint8_t>(i + 1);
  info.name = "org.example.esc";
  bool found = false;
  for (const vectors::Transfer& v : vectors::kTransfers) {
    if (v.name != "GetNodeInfo.Response") continue;
    found = true;
    CHECK(written(info) == bytes_of(v.payload));
  }
  CHECK(found);
}

TEST_CASE("commands and readings beyond a field's range saturate, they never wrap") {
  RawCommand command;
  command.count = 2;
  command.cmd = {32767, -32768};
  const auto raw = read_raw_command(written(command));
  CHECK(raw->cmd[0] == 8191);
  CHECK(raw->cmd[1] == -8192);
  EscStatus status;
  status.rpm = 1'000'000;
  status.voltage = 1e9F;
  status.power_rating_pct = 255;
  status.esc_index = 255;
  const auto esc = read_esc_status(written(status));
  CHECK(esc->rpm == 131071);
  CHECK(esc->voltage == 65504.0F);
  CHECK(esc->power_rating_pct == 127);
  CHECK(esc->esc_index == 31);
  status.rpm = -1'000'000;
  CHECK(read_esc_status(written(status))->rpm == -131072);
  NodeStatus node;
  node.health = node.mode = node.sub_mode = 255;
  CHECK(read_node_status(written(node))->health == 3);
  CHECK(read_node_status(written(node))->mode == 7);
}

TEST_CASE("a name of more than 80 characters is cut, the payload stays within its room") {
  NodeInfo info;
  const std::string name(200, 'x');
  info.name = name;
  CHECK(written(info).size() <= 41 + 80);
}

TEST_CASE("a payload too short for its type gives no message") {
  for (std::size_t n = 0; n < 14; ++n) CHECK_FALSE(read_esc_status(Bytes(n)));
  CHECK(read_esc_status(Bytes(14)));
  for (std::size_t n = 0; n < 7; ++n) CHECK_FALSE(read_node_status(Bytes(n)));
  CHECK(read_node_status(Bytes(7)));
  CHECK_FALSE(read_arming_status(Bytes{}));
  CHECK_FALSE(read_safety_state(Bytes{}));
  CHECK(read_safety_state(Bytes{255})->status == SafetyState::kOff);
  CHECK_FALSE(read_button(Bytes{1}));
  CHECK(read_button(Bytes{1, 3})->button == Button::kSafety);
}

TEST_CASE("any bytes of any length are read without a crash, at most twenty commands") {
  constexpr std::uint32_t kSeed = 34;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  for (int i = 0; i < 20'000; ++i) {
    Bytes bytes(random() % 70);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    const auto command = read_raw_command(bytes);
    if (command) REQUIRE(command->count <= 20);
    read_esc_status(bytes);
    read_node_status(bytes);
    read_arming_status(bytes);
    read_safety_state(bytes);
    read_button(bytes);
  }
}

}  // namespace
}  // namespace flotilla::link
