// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cstdlib>

#include "app/fleet/ledger.hpp"
#include "app/fleet/table.hpp"
#include "app/fleet/tables.hpp"

namespace flotilla::app {
namespace {

using testing::table_of_four;

TEST_CASE("a table survives encoding and decoding") {
  FleetTable table = table_of_four(7);
  table.turns = true;
  table.members[2].slot_cm = {-32'768, 32'767};
  table.members[0].only_leads = true;
  const FleetTable back = table_of(message_of(table, 250));
  CHECK(message_of(table, 250).in_ms == 250);
  CHECK(back.epoch == 7);
  CHECK(back.turns);
  CHECK_FALSE(back.stop);
  REQUIRE(back.count == 4);
  CHECK(back.members[0].only_leads);
  CHECK(back.members[0].can_lead);
  CHECK(back.members[2].slot_cm == std::array<std::int16_t, 2>{-32'768, 32'767});
  CHECK(back.members[3].leader == 1);
  CHECK(back.members[3].length_dm == 13);
}

TEST_CASE("tables that differ have different digests, whatever their epochs") {
  CHECK(table_of_four(1).digest == table_of_four(2).digest);
  FleetTable other = table_of_four(1);
  other.members[3].slot_cm[0] = -1201;
  CHECK(table_of(message_of(other, 0)).digest != table_of_four(1).digest);
  CHECK(table_of_four(1, true).digest > table_of_four(1).digest);
}

TEST_CASE("the digest ignores unknown flags and bytes after the members, which are not passed on") {
  link::FleetTable message = message_of(table_of_four(1), 0);
  message.flags |= 0x40U;
  message.members[8 * 5] = 9;
  CHECK(table_of(message).digest == table_of_four(1).digest);
}

TEST_CASE("an invalid table is refused, with the name of the boat at fault") {
  CHECK(verdict_of(table_of_four(1)).fault == TableFault::kNone);
  CHECK(verdict_of(table_of_four(0)).fault == TableFault::kEmpty);
  CHECK(verdict_of(FleetTable{.epoch = 1}).fault == TableFault::kEmpty);
  FleetTable bad = table_of_four(1);
  bad.members[2].system = 2;
  CHECK(verdict_of(bad).fault == TableFault::kTwice);
  bad = table_of_four(1);
  bad.members[1].leader = 3;  // of lower rank: this would allow a cycle
  CHECK(verdict_of(bad).fault == TableFault::kTree);
  CHECK(verdict_of(bad).system == 2);
  bad = table_of_four(1);
  bad.members[2].only_leads = true;
  CHECK(verdict_of(bad).fault == TableFault::kTree);
  bad = table_of_four(1);
  bad.members[0].can_lead = false;
  CHECK(verdict_of(bad).fault == TableFault::kNoLeader);
  bad = table_of_four(1);
  bad.members[3].slot_cm = {-690, 0};
  CHECK(verdict_of(bad).fault == TableFault::kTooClose);
  CHECK(verdict_of(bad).system == 3);
  CHECK(verdict_of(bad).other == 4);
  bad.stop = true;  // passed on, so that it stops also boats that do not hear the operator
  CHECK(verdict_of(bad).fault == TableFault::kNone);
  bad.stop = false;
  bad.members[3].slot_cm = {-530, 0};  // a hull's length from both
  bad.members[2].slot_cm = {-660, 0};
  CHECK(verdict_of(bad).fault == TableFault::kNone);
}

TEST_CASE("the newest table wins, and comes into force at its time as a whole") {
  FleetLedger ledger;
  CHECK(ledger.current() == nullptr);
  CHECK(ledger.take(table_of_four(1), 1'000'000, 0));
  CHECK(ledger.newest().epoch == 1);
  CHECK(ledger.current() == nullptr);
  CHECK(ledger.valid_us() == 1'000'000);
  CHECK_FALSE(ledger.is_due(999'999));
  CHECK(ledger.is_due(1'000'000));
  ledger.forward(1'000'000);
  CHECK(ledger.current()->epoch == 1);
  CHECK(ledger.valid_us() == 1'000'000);
  CHECK_FALSE(ledger.replaces(0, 0));  // it replaces none
  CHECK(ledger.take(table_of_four(3), 5'000'000, 2'000'000));
  CHECK_FALSE(ledger.take(table_of_four(2), 3'000'000, 2'000'000));
  CHECK_FALSE(ledger.take(table_of_four(3), 4'000'000, 2'000'000));  // an earlier copy
  CHECK(ledger.is_due(4'000'000));
  CHECK(ledger.current()->epoch == 1);
  for (int held = 0; held < 2; ++held) {
    CHECK(ledger.replaces(1, table_of_four(1).digest));
    CHECK_FALSE(ledger.replaces(2, table_of_four(1).digest));
    CHECK_FALSE(ledger.replaces(0, 0));
    ledger.forward(4'000'000);
  }
}

TEST_CASE("a table in force is passed on with the time since then, in steps of 0.1 s") {
  const FleetTable table = table_of_four(1);
  for (const int ms : {-1, -49, -50, -5000, -3'600'000}) {
    const link::FleetTable message = message_of(table, ms);
    CHECK(std::abs(in_ms_of(message) - ms) <= 50);
    CHECK(table_of(message).digest == table.digest);
  }
  CHECK(in_ms_of(message_of(table, 90'000)) == 65'535);
  CHECK(in_ms_of(message_of(table, -90'000'000)) == -6'553'500);
}

TEST_CASE("two tables with the same epoch: all boats choose the same one") {
  FleetTable other = table_of_four(1);
  other.members[3].slot_cm[0] = -1300;
  const FleetTable a = table_of_four(1), b = table_of(message_of(other, 0));
  FleetLedger first, second;
  static_cast<void>(first.take(a, 0, 0));
  static_cast<void>(first.take(b, 0, 0));
  static_cast<void>(second.take(b, 0, 0));
  static_cast<void>(second.take(a, 0, 0));
  CHECK(first.newest().digest == second.newest().digest);
}

TEST_CASE("a stop acts at once") {
  FleetLedger ledger;
  CHECK(ledger.take(table_of_four(1), 0, 0));
  ledger.forward(0);
  CHECK(ledger.take(table_of_four(2, true), 60'000'000, 1'000));
  CHECK(ledger.is_due(1'000));
}

}  // namespace
}  // namespace flotilla::app
