// SPDX-License-Identifier: MIT
// The simulated devices and wires of many lockstep runs: navigation units, boats, ESCs, radio
// links, clocks. No physics: the caller supplies the sensors' measurements and reads the motors'
// commands. Its test oracle is tests/loop/vessel.py, byte for byte.
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

#include "app/boat/boat.hpp"
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

/// The sensors' measurements at a tick, and the output for the ESCs' commands. eta, nu: `agents` ×
/// 3; degE7: `agents` × 2, nullptr if no unit sends degrees; rpm, command: `boats` × 2.
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

/// An agent broke this rule.
struct Violation {
  std::size_t agent;
  std::int64_t t_us;
  std::string_view rule;
};

/// S: scalar of the boats' law. Agents and links are numbered from 0 in order of adding; callers
/// check that they exist. Times are the world's, µs.
template <class S>
class Fleet {
 public:
  /// injects: boats obey MAV_CMD_INJECT_FAILURE.
  Fleet(bool records, bool profiles, bool injects)
      : records_(records), profiles_(profiles), injects_(injects) {}

  std::size_t add_leader(std::int64_t run, std::uint8_t system, const UnitSettings& unit,
                         const Clock& clock);
  std::size_t add_boat(std::int64_t run, const app::Parameters& parameters,
                       const UnitSettings& unit, const Clock& clock);
  std::size_t connect(std::size_t sender, std::size_t receiver, const LinkQuality& quality,
                      std::uint64_t seed);

  /// One control tick of all: leaders' units, then the boats, then reception of undelayed messages.
  void tick(std::int64_t t_us, const TickArrays& arrays);

  /// Delivers bytes on a boat's link, or a frame on its bus to firmware and ESCs.
  void hear(std::size_t boat, std::span<const std::uint8_t> data, std::int64_t t_us,
            std::size_t link);
  void on_can(std::size_t boat, std::uint32_t can_id, std::span<const std::uint8_t> data,
              std::int64_t t_us);
  void command(std::size_t boat, const Order& order, std::int64_t t_us);
  /// From the ground station.
  void heartbeat(std::size_t boat, std::int64_t t_us);

  /// In force from the next tick on; replaces an active fault of the same kind. Throws
  /// std::invalid_argument if a clock would go back before 0.
  void set_fault(std::size_t agent, const Fault& fault, std::int64_t t_us);
  /// Ends the fault of that kind and ESC; does nothing if there is none.
  void clear_fault(std::size_t agent, const Fault& fault, std::int64_t t_us);

  std::size_t agents() const { return agents_.size(); }
  std::size_t boats() const { return boats_.size(); }
  std::size_t links() const { return links_.size(); }
  bool records() const { return records_; }
  bool tells_degrees() const { return tells_degrees_; }

  /// An agent's number among the boats; nothing for a leader.
  std::optional<std::size_t> boat_of(std::size_t agent) const;
  const app::Boat<S>& boat(std::size_t boat) const { return boats_[boat].firmware; }
  RadioLink& link(std::size_t link) { return links_[link]; }
  /// nullptr if no agent was added to it
  Run* run(std::int64_t run);

  /// An agent's radio output of the last tick.
  std::span<const std::uint8_t> sent(std::size_t agent) const;

  /// Each boat's first violation, in order of time.
  const std::vector<Violation>& violations() const { return violations_; }

  /// Seconds by stage since the last call.
  Seconds take_profile() { return std::exchange(profile_, Seconds{}); }

 private:
  /// A leader, or the part of a boat that a leader has too.
  struct Station {
    Clock clock;
    NavigationUnit unit;
    Run* run;
    std::size_t agent;   // in the fleet
    std::size_t number;  // in the run
    std::uint8_t system;
    std::vector<std::uint32_t> inbox{}, outbox{};
    std::int64_t now_us = 0;                 // its clock at the tick
    std::int64_t jumped_us = 0;              // jump of its clock; the ESCs have their own
    bool was_set = false;                    // its clock, or its unit's: stamps may be wrong
    std::vector<std::uint8_t> sent{};        // radio output of the last tick
    std::unique_ptr<VesselFaults> faults{};  // nullptr: none active

    bool has(FaultKind kind) const { return faults && faults->has(kind); }
  };
  using Outbox = app::Outbox<kLinks>;
  struct Vessel {
    Vessel(Station place, const app::Parameters& p, Outbox& outbox);
    Vessel(const Vessel&) = delete;  // the firmware holds references to this room
    Vessel& operator=(const Vessel&) = delete;

    Station station;
    EscNodes escs;
    app::Room<kLinks, 0, 50, 20, 4> room;  // no message is signed
    app::Boat<S> firmware;
    policies::Monitor<S> monitor;
    std::uint8_t leader = 0;                  // system id
    std::optional<std::size_t> leader_agent;  // of the run, with that id
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
  void tell_clocks(Vessel& v, std::int64_t t_us);
  void measure(Station& s, const TickArrays& arrays, std::vector<std::uint8_t>& out);
  void put_on_bus(Vessel& v, std::int64_t t_us, const double* rpm);
  void pass_on(Vessel& v, const typename app::Boat<S>::Output& out, std::int64_t t_us);
  void broadcast(Station& s, std::int64_t t_us);
  void listen(Vessel& v, std::int64_t t_us);
  void listen(Station& s, std::int64_t t_us);
  void hear(Vessel& v, std::span<const std::uint8_t> data, std::int64_t t_us, std::size_t link);
  static void add_unit(Station& s, const Fault& fault);
  void shift_clock(Station& s, std::int64_t by_us, std::int64_t t_us);
  void delay_radio(const Station& s, double by_s);
  void report_bus(Vessel& v, std::int64_t t_us);
  void restart(Vessel& v, std::int64_t t_us);
  void inject(Vessel& v, std::int64_t t_us);
  void hear_operator(Vessel& v, std::span<const std::uint8_t> frame, std::int64_t t_us);
  static Sensed sensed(const TickArrays& arrays, std::size_t agent);

  bool records_, profiles_, injects_;
  bool tells_degrees_ = false;
  std::vector<Agent> agents_;
  std::deque<Station> leaders_;
  Outbox outbox_;  // shared: used by one boat at a time
  HugePageList<Vessel> boats_;
  std::vector<RadioLink> links_;
  std::map<std::int64_t, Run> runs_;
  std::vector<std::uint8_t> chunk_;  // of the current unit
  EscNodes::Frames frames_;          // of the current ESCs
  Seconds profile_{};
  std::vector<Violation> violations_;
};

}  // namespace flotilla::fleet
