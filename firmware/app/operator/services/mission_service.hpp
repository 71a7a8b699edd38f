// SPDX-License-Identifier: MIT
// MAVLink's mission protocol: takes a ground station's plan, fence or rally points, keeps them, and
// gives them back. The old ones stay until the last item of the new ones has come.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "app/operator/requests/commands.hpp"
#include "app/plan/fence.hpp"
#include "app/plan/plan_check.hpp"

namespace flotilla::app {

/// Kinds of stored items; the values are MAV_MISSION_TYPE's.
enum class Stored : std::uint8_t { kPlan, kFence, kRally };
constexpr std::size_t kStoredKinds = 3;
/// Id of a fence that could not be restored; no stored list has it.
constexpr std::uint32_t kLostId = 1;

/// Room for the stored items, and for an upload, which may be as long as any of them.
struct MissionRoom {
  std::array<std::span<PlanItem>, kStoredKinds> stored;
  std::span<PlanItem> incoming;
  std::span<Fence::Place> corners;  ///< one for each item of the fence
};

class MissionService {
 public:
  /// The room must outlive this object. homes: a plan may begin with its sender's home.
  MissionService(const MissionRoom& room, bool homes)
      : homes_(homes), incoming_(room.incoming), fence_(room.corners) {
    for (std::size_t kind = 0; kind < kStoredKinds; ++kind) stores_[kind].room = room.stored[kind];
  }

  Plan stored(Stored kind) const { return store(kind).items(); }
  Plan plan() const { return stored(Stored::kPlan); }

  /// Changes with the stored items; 0: none, kLostId: a lost fence.
  std::uint32_t id(Stored kind) const { return store(kind).id; }

  /// At the start: restores saved items, unless they are not sound. A plan that leaves the fence is
  /// restored, too, but AUTO is refused.
  PlanFault restore(Stored kind, Plan items, const PlanDefaults& defaults);
  /// At the start: the saved fence cannot be restored. It is lost until an operator has sent or
  /// cleared the fence.
  void lose_fence() { store(Stored::kFence).id = kLostId; }
  bool fence_is_lost() const { return id(Stored::kFence) == kLostId; }

  /// The sender, and its rights: the plan may not change while it is sailed, fence and rally points
  /// not while the law drives.
  struct Asker {
    link::Address from;
    std::uint8_t link = 0;
    bool may_command = false, in_auto = false, law_drives = false;
    bool may_change(Stored kind) const {
      return may_command && !(kind == Stored::kPlan ? in_auto : law_drives);
    }
  };

  /// The answer to a message of the mission protocol; nothing where none is due.
  std::optional<link::Message> answer(const RequestMessage& asked, const Asker& asker,
                                      const PlanDefaults& defaults, std::int64_t now_us);

  /// A message to repeat, because the sender of the items is silent.
  struct Repeated {
    std::uint8_t link;
    link::Message message;
  };
  std::optional<Repeated> repeat(std::int64_t now_us);

  /// News for the operator: items were stored or refused, or the stored plan leaves the fence.
  struct News {
    enum class Kind : std::uint8_t { kStored, kRefused, kPlanLeavesFence };
    Kind kind = Kind::kRefused;
    Stored what = Stored::kPlan;
    std::size_t item = 0;  ///< where it was refused, from 0
    std::string_view why{};
  };
  std::optional<News> take_news();

  /// The item to which the boat sails next, and with which AUTO begins.
  std::size_t current() const { return current_; }
  bool is_begun() const { return current_ > homes_of(plan()) || progress_.jumps() > 0; }
  bool is_complete() const { return complete_; }
  /// Call when AUTO begins: after its end, the plan begins anew.
  void begin_round();
  /// How often a plan was stored, began anew, or an operator set its item.
  std::uint32_t round() const { return round_; }
  /// False if there is no such item. anew, or at the first item: no jump counts as taken.
  bool set_current(std::size_t item, bool anew);
  /// Whether an operator has set the current item since the last call.
  bool take_item_set();
  /// Passes the items up to the one ahead. complete: the plan is at its end.
  void sailed(const PlanMark& ahead, bool complete);
  /// Whether the plan pauses after an item whose autocontinue is 0. Not with ArduPilot's identity:
  /// its clients send 0 without intending a pause.
  bool pauses() const { return !homes_; }
  /// Of the plan, up to the current item.
  const PlanProgress& progress() const { return progress_; }

  const Fence& fence() const { return fence_; }
  /// Draws the fence's map from the boat's origin.
  void locate(const link::GpsGlobalOrigin& origin) { fence_.locate(origin); }
  /// Switches the fence on or off; false if none is stored.
  bool enable_fence(bool on);
  /// Once a tick: judges the plan by the fence, a few legs at a time.
  void check_plan(const PlanDefaults& defaults);
  /// How far, m, the boat may be from the place where AUTO begins: farther if it continues its plan
  /// or jumps in it.
  float start_m(std::size_t item) const {
    return item > homes_of(plan()) ? kErrandReach_m : kPlanStart_m;
  }
  /// Why the boat cannot go straight to an item's place, or the first place after it: the place is
  /// too far away, or the path leaves the fence. Empty if it can. anew: no jump counts as taken.
  std::string_view refusal_of_way(const convert::Position& here, std::size_t item,
                                  const PlanDefaults& defaults, bool anew = false) const;
  /// Before AUTO: judges the path from the boat to the place where the plan begins. Call
  /// forget_way() when that judgement is out of date, because the boat has moved.
  void check_way(const convert::Position& here, const PlanDefaults& defaults);
  void forget_way() { way_why_ = {}; }
  /// Whether the plan and the way to it can be sailed. In AUTO, a plan is sound until a fault is
  /// found.
  bool plan_is_sound(bool in_auto) const;
  /// Why the plan or the way to it cannot be sailed; empty if no fault is known.
  std::string_view plan_trouble() const { return check_.why().empty() ? way_why_ : check_.why(); }

  /// The place to which a boat at `here` returns: the nearest permitted rally point with a
  /// straight way; or home if the way there is straight; or the nearest permitted rally point; or
  /// home. fence_m: the farthest from home.
  convert::GlobalPoint return_place(const convert::Position& here, const convert::GlobalPoint& home,
                                    const PlanDefaults& defaults,
                                    const std::optional<float>& fence_m) const;

 private:
  struct Store {
    std::span<PlanItem> room{};
    std::size_t count = 0;
    std::uint32_t id = 0;
    link::Address from{};  ///< of the upload
    std::uint8_t link = 0;
    Plan items() const { return room.first(count); }
  };
  struct Upload {
    Asker asker;
    Stored kind = Stored::kPlan;
    std::size_t count = 0, next = 0;  ///< items
    std::int64_t asked_us = 0;
    int tries = 0;
    bool judged = true;  ///< all items by the present fence
  };
  /// The fence and the parameters by which the stored plan was judged.
  struct Checked {
    std::uint32_t map = 0;  ///< the fence's
    float margin_m = 0, radius_m = 0;
    bool operator==(const Checked&) const = default;
  };

  Store& store(Stored kind) { return stores_[static_cast<std::size_t>(kind)]; }
  const Store& store(Stored kind) const { return stores_[static_cast<std::size_t>(kind)]; }
  std::size_t homes_of(Plan items) const;
  /// The items without a leading home.
  Plan sailed_of(Stored kind, Plan items) const;
  std::optional<link::Message> begin(const link::MissionCount& count, const Asker& asker,
                                     std::int64_t now_us);
  std::optional<link::Message> take(const link::MissionItemInt& item, const Asker& asker,
                                    const PlanDefaults& defaults, std::int64_t now_us);
  link::Message clear(const link::MissionClearAll& asked, const Asker& asker);
  PlanFault fault_of_last_incoming(const PlanDefaults& defaults) const;
  link::Message finish(const Asker& asker);
  void judge_anew();
  link::Message refuse(const Asker& asker, Stored kind, const PlanFault& fault);
  link::Message ask(std::int64_t now_us);
  link::Message item(std::size_t seq, const link::Address& to, std::uint8_t type) const;
  bool is_from_uploader(const Asker& asker) const;
  void replace(Stored kind, Plan items);

  bool homes_;
  std::array<Store, kStoredKinds> stores_;
  std::span<PlanItem> incoming_;
  Fence fence_;
  PlanCheck check_;
  Checked checked_;
  std::string_view way_why_{};
  std::size_t current_ = 0;
  PlanProgress progress_;
  std::uint32_t round_ = 0;
  bool complete_ = false, item_set_ = false;
  std::optional<Upload> upload_;
  std::optional<News> news_;
};

}  // namespace flotilla::app
