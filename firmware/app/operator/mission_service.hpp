// SPDX-License-Identifier: MIT
// MAVLink's mission protocol: takes a ground station's plan, keeps it, and gives it back. The old
// plan stays until the last item of a new one has come. Fences and rally points are refused.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "app/guidance/plan.hpp"
#include "app/operator/commands.hpp"

namespace flotilla::app {

class MissionService {
 public:
  /// Half of the room is for the plan, half for the one that is being sent; it must outlive this
  /// object.
  explicit MissionService(std::span<PlanItem> room)
      : plan_(room.first(room.size() / 2)), incoming_(room.subspan(room.size() / 2)) {}

  Plan plan() const { return plan_.first(count_); }

  /// Changes with each plan; 0: there is none.
  std::uint32_t id() const { return id_; }

  /// At the start: the plan of before, unless it is not sound.
  PlanFault restore(Plan plan, const PlanDefaults& defaults);

  /// Who asks, and what he may do.
  struct Asker {
    link::Address from;
    std::uint8_t link = 0;
    bool may_change = false;  ///< the plan; not while it is being sailed
  };

  /// The answer to a message of the mission protocol; nothing where none is due.
  std::optional<link::Message> answer(const RequestMessage& asked, const Asker& asker,
                                      const PlanDefaults& defaults, std::int64_t now_us);

  /// A message to repeat, as the sender of a plan is silent.
  struct Repeated {
    std::uint8_t link;
    link::Message message;
  };
  std::optional<Repeated> repeat(std::int64_t now_us);

  /// What the operator should read of the last message: a plan was stored, or refused.
  struct News {
    bool stored = false;
    std::size_t item = 0;  ///< where it was refused, from 0
    std::string_view why{};
  };
  std::optional<News> take_news();

  /// The item that is sailed to next; where AUTO begins.
  std::size_t current() const { return current_; }
  bool is_complete() const { return complete_; }
  /// False if there is no such item.
  bool set_current(std::size_t item);
  /// An operator has set it since the last call.
  bool take_jump();
  void sailed(std::size_t item, bool complete);

 private:
  struct Upload {
    Asker asker;
    std::size_t count = 0, next = 0;  ///< items
    std::int64_t asked_us = 0;
    int tries = 0;
  };

  std::optional<link::Message> begin(const link::MissionCount& count, const Asker& asker,
                                     std::int64_t now_us);
  std::optional<link::Message> take(const link::MissionItemInt& item, const Asker& asker,
                                    const PlanDefaults& defaults, std::int64_t now_us);
  link::Message finish(const Asker& asker);
  link::Message refuse(const Asker& asker, const PlanFault& fault, std::size_t item);
  link::Message ask(std::int64_t now_us);
  link::Message item(std::size_t seq, const link::Address& to, std::uint8_t type) const;
  bool is_from_uploader(const Asker& asker) const;
  void replace(std::size_t count);

  std::span<PlanItem> plan_, incoming_;
  std::size_t count_ = 0, current_ = 0;
  std::uint32_t id_ = 0;
  bool complete_ = false, jumped_ = false;
  std::optional<Upload> upload_;
  link::Address stored_from_{};
  std::optional<News> news_;
};

}  // namespace flotilla::app
