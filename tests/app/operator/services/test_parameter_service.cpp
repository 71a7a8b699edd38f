// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "app/operator/services/parameter_service.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;
using Outcome = SetResult::Outcome;

constexpr link::Address kOperator{255, 190};
constexpr std::size_t kHere = 1, kElsewhere = 3;  // links

/// A name as clients send it: at most 16 characters, no NUL after the 16th.
link::Text<16> name_of(const std::string& name) {
  link::Text<16> text{};
  std::strncpy(text.data(), name.c_str(), text.size());
  return text;
}

std::string name_in(const link::Text<16>& text) {
  return {text.data(), ::strnlen(text.data(), text.size())};
}

/// A boat's parameters, and the messages received on its links.
struct Boat {
  std::array<ParameterService::Owed, 4> room;
  ParameterService service{room};
  Parameters values;
  bool armed = false;
  std::uint8_t system = 0;

  SetResult set(const std::string& name, float value, std::uint8_t type = mav::kParamReal32) {
    return service.set(kHere, kOperator, {value, {1, 1}, name_of(name), type}, values,
                       {armed, system});
  }
  void read(std::int16_t index, const std::string& name = "") {
    service.read(kHere, kOperator, {index, {1, 1}, name_of(name)});
  }
  std::vector<link::Message> heard(std::size_t link) {
    std::vector<link::Message> messages;
    while (auto message = service.next(link, values)) {
      messages.push_back(*message);
      REQUIRE(messages.size() < 1000);
    }
    return messages;
  }
};

/// Whether the message has the parameter's value in force, its index and the count.
void check_value(const link::Message& message, const Boat& boat, const ParameterInfo& info) {
  const auto* value = std::get_if<link::ParamValue>(&message);
  REQUIRE(value);
  CHECK(name_in(value->param_id) == info.name);
  CHECK(value->param_value == boat.values.*info.member);
  CHECK(value->param_type == mav::kParamReal32);
  CHECK(value->param_count == kParameterList.size());
  REQUIRE(value->param_index < kParameterList.size());
  CHECK(&kParameterList[value->param_index] == &info);
}

void check_error(const link::Message& message, const std::string& name, std::uint8_t what) {
  const auto* error = std::get_if<link::ParamError>(&message);
  REQUIRE(error);
  CHECK(error->target == kOperator);
  CHECK(name_in(error->param_id) == name);
  CHECK(int{error->error} == int{what});
}

/// All links get the value in force; the operator gets the error before it.
void check_refusal(Boat& boat, const ParameterInfo& info, std::uint8_t error) {
  const auto here = boat.heard(kHere), elsewhere = boat.heard(kElsewhere);
  REQUIRE(here.size() == 2);
  check_error(here[0], std::string(info.name), error);
  CHECK(std::get<link::ParamError>(here[0]).param_index == &info - kParameterList.data());
  check_value(here[1], boat, info);
  REQUIRE(elsewhere.size() == 1);
  check_value(elsewhere[0], boat, info);
}

void check_answer_to_all(Boat& boat, const ParameterInfo& info) {
  for (const std::size_t link : {kHere, kElsewhere}) {
    const auto messages = boat.heard(link);
    REQUIRE(messages.size() == 1);
    check_value(messages[0], boat, info);
  }
}

TEST_CASE("any value allowed alone and with the others is accepted and sent to all") {
  std::mt19937 random(7);
  for (const ParameterInfo& info : kParameterList) {
    CAPTURE(std::string(info.name));
    for (int round = 0; round < 40; ++round) {
      Boat boat;
      std::uniform_real_distribution<float> any(info.least, info.greatest);
      const float drawn = any(random);
      const float value = info.kind == ParameterKind::kSign ? std::copysign(1.0F, drawn)
                          : info.whole()                    ? std::round(drawn)
                                                            : drawn;
      Parameters desired;
      desired.*info.member = value;
      if (!is_valid(info, value) || contradiction(desired)) continue;
      CAPTURE(value);
      const bool same = boat.values.*info.member == value;
      const SetResult result = boat.set(std::string(info.name), value);
      CHECK(result.outcome == (same ? Outcome::kUnchanged : Outcome::kSet));
      CHECK(result.info == &info);
      CHECK(result.sentence.text().empty());
      CHECK(boat.values.*info.member == value);
      check_answer_to_all(boat, info);
      if (info.name == "MAV_GCS_SYSID") continue;  // it may lock this operator out
      CHECK(boat.set(std::string(info.name), value).outcome == Outcome::kUnchanged);
      check_answer_to_all(boat, info);
    }
  }
}

TEST_CASE("a NaN, out-of-range or non-whole value changes nothing and is reported") {
  for (const ParameterInfo& info : kParameterList) {
    std::vector<float> bad{NAN,
                           -NAN,
                           INFINITY,
                           -INFINITY,
                           3e38F,
                           -3e38F,
                           std::nextafter(info.least, -1e9F),
                           std::nextafter(info.greatest, 1e9F)};
    if (info.whole()) bad.push_back(info.least + 0.5F);
    if (info.kind == ParameterKind::kSign) bad.push_back(0);
    for (const float value : bad) {
      CAPTURE(std::string(info.name));
      CAPTURE(value);
      Boat boat;
      const SetResult result = boat.set(std::string(info.name), value);
      CHECK(result.outcome == Outcome::kRefused);
      CHECK(result.info == &info);
      CHECK(result.error == mav::kParamOutOfRange);
      CHECK(result.sentence.text().starts_with(std::string(info.name) + " "));
      CHECK(result.sentence.text().find(" refused: ") != std::string_view::npos);
      CHECK(boat.values.*info.member == info.default_value());
      check_refusal(boat, info, mav::kParamOutOfRange);
    }
  }
}

TEST_CASE("a refusal states the allowed values") {
  Boat boat;
  const auto said = [&](const char* name, float value) {
    return std::string(boat.set(name, value).sentence.text());
  };
  CHECK(said("LAW_KX", 9) == "LAW_KX 9 refused: 0 to 2 1/s");
  CHECK(said("SR_SLOW", -0.5F) == "SR_SLOW -0.5 refused: 0 to 50 Hz");
  CHECK(said("FORM_LEADER", 0) == "FORM_LEADER 0 refused: whole numbers, 1 to 255");
  CHECK(said("THR_PORT_DIR", 0) == "THR_PORT_DIR 0 refused: -1 or 1");
  CHECK(said("MODE", 6) == "MODE is an unknown parameter");
  CHECK(said("MAV_COMPID", NAN) == "MAV_COMPID nan refused: whole numbers, 1 to 250");
  CHECK(said("ESC_PORT", 1) == "ESC_PORT 1 refused: ESC_PORT and ESC_STBD are the same ESC");
  CHECK(said("MAV_IDENTITY", 1) ==
        "MAV_IDENTITY 1 refused: companion (MAV_IDENTITY 1): set MAV_COMPID 191");
  boat.armed = true;
  CHECK(said("THR_ARM", 2) == "THR_ARM 2 refused: only while disarmed");
}

TEST_CASE("while armed, only parameters that may change at any time do") {
  for (const ParameterInfo& info : kParameterList) {
    CAPTURE(std::string(info.name));
    Boat boat;
    // halfway to a limit, if there is room
    const float to = info.default_value() == info.greatest ? info.least : info.greatest;
    const float value = info.whole() ? to : (info.default_value() + to) / 2;
    Parameters desired;
    desired.*info.member = value;
    if (contradiction(desired)) continue;
    boat.armed = true;
    const auto result = boat.set(std::string(info.name), value);
    if (info.change == ParameterChange::kAnytime) {
      CHECK(result.outcome == Outcome::kSet);
      CHECK(boat.values.*info.member == value);
      check_answer_to_all(boat, info);
    } else {
      CHECK(result.outcome == Outcome::kRefused);
      CHECK(boat.values.*info.member == info.default_value());
      check_refusal(boat, info, mav::kParamPermissionDenied);
    }
    // A repeated set changes nothing.
    CHECK(boat.set(std::string(info.name), boat.values.*info.member).outcome ==
          Outcome::kUnchanged);
  }
}

TEST_CASE("of two values that exclude each other, the second is refused, in either order") {
  Boat boat;
  CHECK(boat.set("ESC_STBD", 0).outcome == Outcome::kRefused);
  check_refusal(boat, *find_parameter("ESC_STBD"), mav::kParamOutOfRange);
  CHECK(boat.set("ESC_PORT", 5).outcome == Outcome::kSet);
  CHECK(boat.set("ESC_STBD", 0).outcome == Outcome::kSet);
  CHECK(boat.set("FORM_LEADER", 1).outcome == Outcome::kRefused);
  CHECK(boat.set("MAV_SYSID", 100).outcome == Outcome::kRefused);
  CHECK_FALSE(contradiction(boat.values));
}

TEST_CASE("any type but REAL32 is a mismatch, whatever its bits would mean as a number") {
  Boat boat;
  for (int type = 0; type < 256; ++type) {
    if (type == mav::kParamReal32) continue;
    CAPTURE(type);
    const auto result = boat.set("LAW_KX", 0.5F, static_cast<std::uint8_t>(type));
    CHECK(result.outcome == Outcome::kRefused);
    check_refusal(boat, *find_parameter("LAW_KX"), mav::kParamTypeMismatch);
  }
}

TEST_CASE("an unknown name is an error to its sender alone, when set or read") {
  Boat boat;
  for (const std::string name :
       {"", "LAW_K", "LAW_KXX", "law_kx", "_HASH_CHECK", "0123456789ABCDEF", "LAW_KX "}) {
    CAPTURE(name);
    const auto result = boat.set(name, 1);
    CHECK(result.outcome == Outcome::kRefused);
    CHECK(result.info == nullptr);
    boat.read(-1, name);
    const auto here = boat.heard(kHere);
    REQUIRE(here.size() == 2);
    for (const auto& message : here) {
      check_error(message, name, mav::kParamDoesNotExist);
      CHECK(std::get<link::ParamError>(message).param_index == -1);
    }
    CHECK(boat.heard(kElsewhere).empty());
  }
}

TEST_CASE("a stranger sets no parameter where only one ground station may command") {
  Boat boat;
  boat.values.MAV_GCS_SYSID = 254;
  CHECK(boat.set("LAW_KX", 1).outcome == Outcome::kRefused);
  check_refusal(boat, *find_parameter("LAW_KX"), mav::kParamPermissionDenied);
  boat.values.MAV_GCS_SYSID = 255;
  CHECK(boat.set("LAW_KX", 1).outcome == Outcome::kSet);
}

TEST_CASE("a boat cannot follow itself, neither by the id in use nor by the configured one") {
  Boat companion;  // MAV_SYSID 1 is configured; the autopilot's id, 42, is in use
  companion.system = 42;
  CHECK(companion.set("FORM_LEADER", 42).outcome == Outcome::kRefused);
  check_refusal(companion, *find_parameter("FORM_LEADER"), mav::kParamOutOfRange);
  CHECK(companion.set("FORM_LEADER", 1).outcome == Outcome::kRefused);
  CHECK(companion.set("FORM_LEADER", 43).outcome == Outcome::kSet);
  companion.values.FORM_LEADER = 42;  // already set when the id was taken: it may stay
  CHECK(companion.set("FORM_LEADER", 42).outcome == Outcome::kUnchanged);
  CHECK(companion.set("LAW_KX", 0.5F).outcome == Outcome::kSet);
  CHECK(companion.set("FORM_LEADER", 100).outcome == Outcome::kSet);
}

TEST_CASE("exactly the names of the list are known, whatever the value") {
  const auto knows = [](const std::string& name) {
    return ParameterService::knows({NAN, {9, 9}, name_of(name), 77});
  };
  for (const ParameterInfo& info : kParameterList) CHECK(knows(std::string(info.name)));
  for (const char* name :
       {"", "LAW_K", "LAW_KX2", "law_kx", "MAV_GCS_SYSIDENTIFIER", "SYSID_THISMAV"})
    CHECK_FALSE(knows(name));
}

TEST_CASE("the list is complete and in order, on the link that asked for it alone") {
  Boat boat;
  boat.service.list(kHere);
  const auto messages = boat.heard(kHere);
  REQUIRE(messages.size() == kParameterList.size());
  for (std::size_t i = 0; i < messages.size(); ++i) {
    check_value(messages[i], boat, kParameterList[i]);
  }
  CHECK(boat.heard(kElsewhere).empty());
}

TEST_CASE("a list requested again half way starts again and is complete") {
  Boat boat;
  boat.service.list(kHere);
  for (int i = 0; i < 11; ++i) REQUIRE(boat.service.next(kHere, boat.values));
  boat.service.list(kHere);
  const auto messages = boat.heard(kHere);
  REQUIRE(messages.size() == kParameterList.size());
  check_value(messages[0], boat, kParameterList[0]);
}

TEST_CASE("lost parts of the list can be requested one by one, by index or by name") {
  Boat boat;
  for (const ParameterInfo& info : kParameterList) {
    CAPTURE(std::string(info.name));
    for (const bool by_name : {false, true}) {
      const auto index = static_cast<std::int16_t>(&info - kParameterList.data());
      by_name ? boat.read(-1, std::string(info.name)) : boat.read(index, "whatever");
      const auto messages = boat.heard(kHere);
      REQUIRE(messages.size() == 1);
      check_value(messages[0], boat, info);
    }
  }
  CHECK(boat.heard(kElsewhere).empty());
}

TEST_CASE("an index that does not exist is an error that names it") {
  Boat boat;
  constexpr auto kCount = static_cast<std::int16_t>(kParameterList.size());
  for (const std::int16_t index : {kCount, std::int16_t(kCount + 1), std::int16_t(32767),
                                   std::int16_t(-2), std::int16_t(-32768)}) {
    CAPTURE(index);
    boat.read(index, "LAW_KX");
    const auto messages = boat.heard(kHere);
    REQUIRE(messages.size() == 1);
    check_error(messages[0], "LAW_KX", mav::kParamDoesNotExist);
    CHECK(std::get<link::ParamError>(messages[0]).param_index == index);
  }
}

TEST_CASE("the value sent is the one in force when it is sent, not when it was requested") {
  Boat boat;
  boat.read(-1, "LAW_KX");
  boat.set("LAW_KX", 0.5F);
  boat.set("LAW_KX", 0.75F);
  check_answer_to_all(boat, *find_parameter("LAW_KX"));
}

/// Number of rounds until a message is `desired`; one message is sent per round, after `flood`.
template <class Flood, class Desired>
int rounds_until(Boat& boat, Flood flood, Desired desired) {
  for (int round = 1; round <= 1000; ++round) {
    flood(round);
    const auto message = boat.service.next(kHere, boat.values);
    if (message && desired(*message)) return round;
  }
  return 1001;
}

TEST_CASE("one kind of request at any rate does not keep the others from being answered") {
  const auto is_value_of = [](std::string name) {
    return [name](const link::Message& m) {
      const auto* value = std::get_if<link::ParamValue>(&m);
      return value && name_in(value->param_id) == name;
    };
  };
  const auto is_error = [](const link::Message& m) {
    return std::holds_alternative<link::ParamError>(m);
  };
  const auto last = std::string(kParameterList.back().name);
  Boat boat;
  const auto unknown = [&](int) { boat.read(-1, "NO_SUCH_NAME"); };
  const auto refused = [&](int) { boat.set("LAW_KX", 9); };
  const auto reads = [&](int round) { boat.read(static_cast<std::int16_t>(round % 20)); };
  const auto all_set = [&](int round) { boat.set("LAW_KX", round % 2 == 0 ? 0.25F : 0.5F); };
  const auto lists = [&](int) { boat.service.list(kHere); };
  constexpr int kAll = 4 * static_cast<int>(kParameterList.size());

  SUBCASE("the list among errors") {
    boat.service.list(kHere);
    CHECK(rounds_until(boat, unknown, is_value_of(last)) <= kAll);
  }
  SUBCASE("the list among refusals") {
    boat.service.list(kHere);
    CHECK(rounds_until(boat, refused, is_value_of(last)) <= kAll);
  }
  SUBCASE("the list among single questions") {
    boat.service.list(kHere);
    CHECK(rounds_until(boat, reads, is_value_of(last)) <= kAll);
  }
  SUBCASE("a single question among lists, errors, refusals and sets") {
    for (int i = 0; i < 4; ++i) {
      boat.read(-1, last);
      CHECK(rounds_until(
                boat,
                [&](int round) {
                  lists(round);
                  unknown(round);
                  refused(round);
                  all_set(round);
                },
                is_value_of(last)) <= 12);
    }
  }
  SUBCASE("a single question among all other single questions") {
    boat.read(-1, last);
    CHECK(rounds_until(
              boat,
              [&](int) {
                for (std::int16_t i = 0; i + 1 < int(kParameterList.size()); ++i) boat.read(i);
              },
              is_value_of(last)) <= kAll);
  }
  SUBCASE("an error among everything else") {
    boat.read(999);
    CHECK(rounds_until(
              boat,
              [&](int round) {
                lists(round);
                reads(round);
                all_set(round);
              },
              is_error) <= 4);
  }
  SUBCASE("the value of a parameter whose sets are refused without end") {
    CHECK(rounds_until(boat, refused, is_value_of("LAW_KX")) <= 2);
    CHECK(rounds_until(boat, refused, is_value_of("LAW_KX")) <= 4);
  }
}

TEST_CASE("with more refusals than queued errors, every parameter's value is still sent to all") {
  Boat boat;
  for (const ParameterInfo& info : kParameterList) boat.set(std::string(info.name), NAN);
  for (const std::size_t link : {kHere, kElsewhere}) {
    std::set<std::string> told;
    for (const auto& message : boat.heard(link)) {
      if (const auto* value = std::get_if<link::ParamValue>(&message)) {
        told.insert(name_in(value->param_id));
      }
    }
    CHECK(told.size() == kParameterList.size());
  }
}

}  // namespace
}  // namespace flotilla::app
