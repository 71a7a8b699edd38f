// SPDX-License-Identifier: MIT
// Everything that is on a wire in lockstep runs, many at once: navigation units, the boats, ESCs,
// radio links, clocks. Knows no physics: it is told what the sensors measure and tells what the
// motors are told. Its oracle is tests/loop/vessel.py, byte for byte.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "app/boat.hpp"
#include "fleet/clock.hpp"
#include "fleet/esc_nodes.hpp"
#include "fleet/huge_page_list.hpp"
#include "fleet/navigation_unit.hpp"
#include "fleet/radio_link.hpp"
#include "fleet/records.hpp"
#include "fleet/stopwatch.hpp"
#include "fleet/vessel_faults.hpp"
#include "policies/monitor.hpp"

namespace flotilla::fleet {

constexpr std::size_t kNavigation = 0, kRadio = 1, kLinks = 2;

/// What the sensors measure at a tick, and where the ESCs' commands go: arrays of `agents` × 3,
/// × 3, × 2 (nullptr where no unit tells degrees), and of `boats` × 2, × 2.
struct TickArrays {
  const double* eta;
  const double* nu;
  const std::int32_t* degE7;
  const double* rpm;
  double* command;
};

/// COMMAND_LONG from a ground station.
struct Order {
  std::uint16_t command;
  std::array<float, 7> params;
};

/// One run's recording and operator.
struct Run {
  std::size_t agents = 0;
  Records records;
  FrameWriter ground_station{{255, 190}};
};

/// An agent broke that rule.
struct Violation {
  std::size_t agent;
  std::int64_t t_us;
  std::string_view rule;
};

/// S: scalar of the boats' law. Agents and links are counted from 0 in order of adding; whoever
/// calls has checked that they exist. Times are the world's, µs.
template <class S>
class Fleet {
 public:
  /// injects: MAV_CMD_INJECT_FAILURE is obeyed.
  Fleet(bool records, bool profiles, bool injects)
      : records_(records), profiles_(profiles), injects_(injects) {}

  std::size_t add_leader(std::int64_t run, std::uint8_t system, const UnitSettings& unit,
                         const Clock& clock);
  std::size_t add_boat(std::int64_t run, const app::Parameters& parameters,
                       const UnitSettings& unit, const Clock& clock);
  std::size_t connect(std::size_t sender, std::size_t receiver, const LinkQuality& quality,
                      std::uint64_t seed);

  /// One control tick of all: leaders' units, then the boats, then whatever has come at once.
  void tick(std::int64_t t_us, const TickArrays& arrays);

  /// Bytes into a boat's link; a frame on its bus, which its firmware and its ESCs hear.
  void hear(std::size_t boat, std::span<const std::uint8_t> data, std::int64_t t_us,
            std::size_t link);
  void on_can(std::size_t boat, std::uint32_t can_id, std::span<const std::uint8_t> data,
              std::int64_t t_us);
  void command(std::size_t boat, const Order& order, std::int64_t t_us);
  /// The ground station's.
  void heartbeat(std::size_t boat, std::int64_t t_us);

  /// From the next tick on; one of the kind takes the place of the last one. std::invalid_argument
  /// where a clock would go back before 0.
  void set_fault(std::size_t agent, const Fault& fault, std::int64_t t_us);
  /// Of its kind, and of its ESC; where there is none, nothing happens.
  void clear_fault(std::size_t agent, const Fault& fault, std::int64_t t_us);

  std::size_t agents() const { return agents_.size(); }
  std::size_t boats() const { return boats_.size(); }
  std::size_t links() const { return links_.size(); }
  bool records() const { return records_; }
  bool tells_degrees() const { return tells_degrees_; }

  /// Which boat an agent is; nothing of a leader.
  std::optional<std::size_t> boat_of(std::size_t agent) const;
  const app::Boat<S>& boat(std::size_t boat) const { return boats_[boat].firmware; }
  RadioLink& link(std::size_t link) { return links_[link]; }
  /// nullptr where no agent was ever added to it
  Run* run(std::int64_t run);

  /// What an agent said over the radio in the last tick.
  std::span<const std::uint8_t> sent(std::size_t agent) const;

  /// What rule each boat has broken first, in the order of time.
  const std::vector<Violation>& violations() const { return violations_; }

  /// Seconds by stage since the last call.
  Seconds take_profile() { return std::exchange(profile_, Seconds{}); }

 private:
  /// A leader, or what a boat has in common with it.
  struct Station {
    Clock clock;
    NavigationUnit unit;
    Run* run;
    std::size_t agent;   // in the fleet
    std::size_t number;  // in the run
    std::uint8_t system;
    std::vector<std::uint32_t> inbox{}, outbox{};
    std::int64_t now_us = 0;           // its clock, at the tick
    std::int64_t jumped_us = 0;        // how far its clock has; not its ESCs', which have their own
    std::vector<std::uint8_t> said{};  // over the radio in the last tick
    std::unique_ptr<VesselFaults> faults{};  // none where there is none

    bool has(FaultKind kind) const { return faults && faults->has(kind); }
  };
  using Outbox = app::Outbox<kLinks>;
  struct Vessel {
    Vessel(Station place, const app::Parameters& p, Outbox& outbox);
    Vessel(const Vessel&) = delete;  // the firmware works in this one's room
    Vessel& operator=(const Vessel&) = delete;

    Station station;
    EscNodes escs;
    app::LinkRoom<kLinks, 0> room;  // nobody signs
    app::Boat<S> firmware;
    policies::Monitor<S> monitor;
  };
  struct Agent {
    bool is_boat;
    std::uint32_t index;
  };

  Station& station_of(std::size_t agent) {
    const auto [is_boat, index] = agents_[agent];
    return is_boat ? boats_[index].station : leaders_[index];
  }
  Station station(std::int64_t run, link::Address self, const UnitSettings& unit,
                  const Clock& clock, bool is_boat);
  template <bool kProfiled>
  void tick_all(std::int64_t t_us, const TickArrays& arrays);
  void tick_leader(Station& s, std::int64_t t_us, const TickArrays& arrays);
  template <bool kProfiled>
  void tick_boat(std::size_t index, std::int64_t t_us, const TickArrays& arrays,
                 Stopwatch<kProfiled>& watch);
  void measure(Station& s, const TickArrays& arrays, std::vector<std::uint8_t>& out);
  void put_on_bus(Vessel& v, std::int64_t t_us, const double* rpm);
  void pass_on(Vessel& v, const typename app::Boat<S>::Output& out, std::int64_t t_us);
  void broadcast(Station& s, std::int64_t t_us);
  void listen(Vessel& v, std::int64_t t_us);
  void listen(Station& s, std::int64_t t_us);
  void hear(Vessel& v, std::span<const std::uint8_t> data, std::int64_t t_us, std::size_t link);
  void shift_clock(Station& s, std::int64_t by_us, std::int64_t t_us);
  void report_bus(Vessel& v, std::int64_t t_us);
  void restart(Vessel& v, std::int64_t t_us);
  void inject(Vessel& v, std::int64_t t_us);
  void hear_operator(Vessel& v, std::span<const std::uint8_t> frame, std::int64_t t_us);
  static Sensed sensed(const TickArrays& arrays, std::size_t agent);

  bool records_, profiles_, injects_;
  bool tells_degrees_ = false;
  std::vector<Agent> agents_;
  std::deque<Station> leaders_;
  Outbox outbox_;  // of the boat whose turn it is
  HugePageList<Vessel> boats_;
  std::vector<RadioLink> links_;
  std::map<std::int64_t, Run> runs_;
  std::vector<std::uint8_t> chunk_;  // of the unit whose turn it is
  EscNodes::Frames frames_;          // of the ESCs whose turn it is
  Seconds profile_{};
  std::vector<Violation> violations_;
};

}  // namespace flotilla::fleet
