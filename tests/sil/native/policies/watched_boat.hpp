// SPDX-License-Identifier: MIT
// A boat under its monitor, for use in a Harbour; its output can be changed after it was sent.
#pragma once

#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "app/harbour.hpp"
#include "policies/monitor.hpp"

namespace flotilla::testing {

template <class S>
class WatchedBoat {
 public:
  WatchedBoat(const app::Parameters& p, std::size_t count) : boat_(p, count), monitor_(p) {}

  /// Changes what goes over the bus, or replaces what goes over the links.
  std::function<void(std::vector<link::CanFrame>&)> bus;
  const app::MavlinkLinks* links = nullptr;

  void on_mavlink(std::span<const std::uint8_t> data, std::int64_t now_us, std::size_t link) {
    boat_.on_mavlink(data, now_us, link);
    monitor_.heard(data);
  }
  void on_can(std::uint32_t id, std::span<const std::uint8_t> data, std::int64_t now_us) {
    boat_.on_can(id, data, now_us);
    monitor_.on_can(id, data);
  }
  typename app::Boat<S>::Output tick(std::int64_t now_us) {
    auto out = boat_.tick(now_us);
    frames_.assign(out.can.begin(), out.can.end());
    if (bus) bus(frames_);
    out.can = frames_;
    if (links != nullptr) out.links = links;
    monitor_.ticked(boat_, out, now_us);
    return out;
  }

  /// The name of the first broken rule, if any.
  std::string_view broken() const {
    return monitor_.broken() ? monitor_.broken()->name : std::string_view();
  }
  const std::optional<policies::Violation>& violation() const { return monitor_.broken(); }
  core::State state() const { return boat_.state(); }
  app::Boat<S>& firmware() { return boat_; }

 private:
  app::Boat<S> boat_;
  policies::Monitor<S> monitor_;
  std::vector<link::CanFrame> frames_;
};

template <class S = float>
using WatchedHarbour = Harbour<S, WatchedBoat<S>>;

}  // namespace flotilla::testing
