// SPDX-License-Identifier: MIT
// The services of plans, fences and rally points alone, without a boat: several senders, requests in
// any order. What is stored changes only by its upload or by a clearing, is sound, reads back as it
// was sent, and leads to a finite number of places.
#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

#include "app/operator/services/mission_service.hpp"
#include "fuzz/guard.hpp"
#include "fuzz/stream.hpp"

namespace flotilla::fuzz {
namespace {

namespace mav = link::mav;
using app::PlanItem;
using app::Stored;

constexpr app::PlanDefaults kDefaults{.speed_mps = 0.5F,
                                      .radius_m = 2,
                                      .fastest_mps = 1.5F,
                                      .margin_m = 1.3F,
                                      .room_m = 60,
                                      .fastest_radps = 1};
constexpr std::int32_t kLatitude = 473977420, kLongitude = 85455940;
constexpr std::array<std::uint16_t, 20> kCommands{mav::kNavWaypoint,
                                                  mav::kNavLoiterUnlimited,
                                                  mav::kNavLoiterTurns,
                                                  mav::kNavLoiterTime,
                                                  mav::kNavReturn,
                                                  mav::kNavDelay,
                                                  mav::kConditionDelay,
                                                  mav::kDoJump,
                                                  mav::kDoChangeSpeed,
                                                  mav::kDoSetHome,
                                                  mav::kDoSetRoi,
                                                  mav::kVoyage,
                                                  mav::kFenceReturnPoint,
                                                  mav::kFenceInclusion,
                                                  mav::kFenceExclusion,
                                                  mav::kFenceCircleInclusion,
                                                  mav::kFenceCircleExclusion,
                                                  mav::kRallyPoint,
                                                  mav::kNavWaypoint,
                                                  mav::kFenceInclusion};
constexpr std::array<std::uint8_t, 6> kFrames{0, 3, 5, 6, 11, 2};
constexpr std::array kKinds{Stored::kPlan, Stored::kFence, Stored::kRally};

/// Storage and service of one boat.
struct Service {
  std::array<PlanItem, 16> plan{};
  std::array<PlanItem, 12> fence{};
  std::array<PlanItem, 4> rally{};
  std::array<PlanItem, 16> incoming{};
  std::array<app::Fence::Place, 12> corners{};
  app::MissionService service;

  explicit Service(bool homes)
      : service({{std::span(plan), std::span(fence), std::span(rally)}, incoming, corners}, homes) {
  }
};

bool equal(app::Plan a, app::Plan b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

class Senders {
 public:
  explicit Senders(Stream& in) : in_(in), homes_((in.byte() & 1U) != 0), boat_(homes_) {
    boat_.service.locate({kLatitude, kLongitude, 0, 0});
  }

  void act() {
    const unsigned byte = in_.byte();
    asker_ = {{static_cast<std::uint8_t>(250U + (byte >> 6U & 1U)), 190},
              static_cast<std::uint8_t>(byte >> 6U & 1U),
              (byte & 0x80U) == 0 || in_.byte() > 32,
              in_auto_,
              in_auto_};
    switch (byte & 15U) {
      case 0:
      case 1:
        return say(
            link::MissionCount{{1, 1}, static_cast<std::uint16_t>(in_.byte() % 18U), type()});
      case 2:
        return say(link::MissionClearAll{{1, 1}, type()});
      case 3:
        return say(link::MissionAck{{1, 1}, in_.byte(), type()});
      case 4:
        return say(link::MissionRequestList{{1, 1}, type()});
      case 5:
        return download();
      case 6:
        return time_passes();
      case 7: {
        const std::uint8_t number = in_.byte();
        boat_.service.set_current(number % 20U, number >= 128);
        return;
      }
      case 8:
        boat_.service.enable_fence((in_.byte() & 1U) != 0);
        return;
      case 9:
        return look();
      case 10:
        in_auto_ = !in_auto_;
        return;
      default:
        return give(byte);
    }
  }

  /// The stored items are sound: another boat takes them, and reads them to their end.
  void judge() {
    for (const Stored kind : kKinds) {
      const app::Plan items = boat_.service.stored(kind);
      require((boat_.service.id(kind) == 0) == items.empty(), "an id stands for what is stored");
      Service other(homes_);
      require(!other.service.restore(kind, items, kDefaults), "what is stored is sound");
      require(equal(other.service.stored(kind), items), "it is restored as it was");
    }
    app::PlanDefaults defaults = kDefaults;
    const app::Plan plan = boat_.service.plan();
    const bool home = homes_ && !plan.empty() && plan[0].command == mav::kNavWaypoint &&
                      plan[0].frame == mav::kFrameGlobal;
    app::PlanReader reader;
    const auto first = std::max<std::size_t>(boat_.service.current(), home ? 1 : 0);
    reader.begin({first, {kLatitude, kLongitude}, {}, boat_.service.progress()}, defaults);
    for (int i = 0; i < 200; ++i) {
      const auto point = reader.next(plan);
      if (!point) break;
      require(point->mark.item < plan.size(), "a place belongs to an item");
      require(point->speed_mps > 0 && point->speed_mps <= 5, "a place has a speed");
    }
  }

 private:
  /// Also all kinds, and none.
  std::uint8_t type() { return in_.one_of(std::array<std::uint8_t, 5>{0, 1, 2, 255, 7}); }

  void say(const app::RequestMessage& asked) {
    std::array<std::uint32_t, 3> before{};
    for (const Stored kind : kKinds) {
      before[static_cast<std::size_t>(kind)] = boat_.service.id(kind);
    }
    std::optional<link::Message> answer;
    {
      const Guard guard;
      answer = boat_.service.answer(asked, asker_, kDefaults, now_us_);
    }
    if (answer) hear(*answer);
    for (const Stored kind : kKinds) {
      const bool same = before[static_cast<std::size_t>(kind)] == boat_.service.id(kind);
      const auto* ack = answer ? std::get_if<link::MissionAck>(&*answer) : nullptr;
      require(same || (ack != nullptr && ack->type == mav::kMissionAccepted),
              "what changes was accepted");
      require(same || asker_.may_change(kind), "who may not command changes nothing");
    }
    boat_.service.take_news();
  }

  void hear(const link::Message& answer) {
    if (const auto* asked = std::get_if<link::MissionRequestInt>(&answer)) next_ = asked->seq;
  }

  void give(unsigned byte) {
    PlanItem item = structured();
    const bool wrong = (byte & 0x20U) != 0 && in_.byte() < 32;
    const auto seq = static_cast<std::uint16_t>(wrong ? in_.byte() : next_);
    say(link::MissionItemInt{{1, 1},
                             seq,
                             item.frame,
                             item.command,
                             0,
                             1,
                             item.param,
                             item.x,
                             item.y,
                             item.z,
                             static_cast<std::uint8_t>(byte >> 4U & 1U ? in_.byte() % 4U : kind_)});
  }

  PlanItem structured() {
    PlanItem item{};
    const unsigned shape = in_.byte();
    item.command = kCommands[shape % kCommands.size()];
    item.frame = kFrames[shape < 240 ? (shape >> 5U) % 2U : shape % kFrames.size()];
    kind_ = item.command == mav::kRallyPoint ? 2 : item.command >= mav::kFenceReturnPoint ? 1 : 0;
    if (item.command == mav::kVoyage) kind_ = 0;
    for (float& param : item.param) {
      const auto choice = in_.byte();
      param = choice < 250 ? static_cast<float>(choice % 32) - 2 : in_.number<float>();
    }
    const auto north = static_cast<std::int8_t>(in_.byte());
    const auto east = static_cast<std::int8_t>(in_.byte());
    item.x = north == 127 ? in_.number<std::int32_t>() : kLatitude + north * 900;
    item.y = east == 127 ? in_.number<std::int32_t>() : kLongitude + east * 1330;
    return item;
  }

  /// Reads back what is stored, item by item.
  void download() {
    const Stored kind = kKinds[in_.byte() % kKinds.size()];
    const app::Plan items = boat_.service.stored(kind);
    for (std::size_t i = 0; i < items.size(); ++i) {
      const auto answer = boat_.service.answer(
          link::MissionRequestInt{
              {1, 1}, static_cast<std::uint16_t>(i), static_cast<std::uint8_t>(kind)},
          asker_, kDefaults, now_us_);
      const auto* told = answer ? std::get_if<link::MissionItemInt>(&*answer) : nullptr;
      require(
          told != nullptr && told->seq == i && told->command == items[i].command &&
              told->x == items[i].x && told->y == items[i].y &&
              std::memcmp(told->param.data(), items[i].param.data(), sizeof items[i].param) == 0,
          "an item reads back as it is stored");
    }
  }

  void time_passes() {
    now_us_ += 10'000 * std::int64_t{in_.byte()};
    const Guard guard;
    if (const auto again = boat_.service.repeat(now_us_)) hear(again->message);
    boat_.service.check_plan(kDefaults);
  }

  void look() {
    const app::convert::Position here{
        int{in_.byte()}, -int{in_.byte()}, {kLatitude, kLongitude, 0, 0}};
    const Guard guard;
    boat_.service.check_way(here, kDefaults);
    boat_.service.return_place(here, {kLatitude, kLongitude}, kDefaults, 100.0F);
    const auto item = static_cast<std::uint16_t>(boat_.service.current());
    boat_.service.sailed({item, boat_.service.progress().jumps()}, false);
  }

  Stream& in_;
  bool homes_, in_auto_ = false;
  Service boat_;
  app::MissionService::Asker asker_;
  std::uint16_t next_ = 0;
  std::uint8_t kind_ = 0;
  std::int64_t now_us_ = 0;
};

}  // namespace
}  // namespace flotilla::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  flotilla::fuzz::Stream in(std::span(data, size));
  flotilla::fuzz::Senders senders(in);
  while (!in.empty()) senders.act();
  senders.judge();
  return 0;
}
