// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <numeric>
#include <random>
#include <set>
#include <thread>
#include <vector>

#include "linux/logs/logs.hpp"
#include "linux/scratch.hpp"
#include "linux/soon.hpp"

namespace flotilla::target {
namespace {

using Bytes = std::vector<std::uint8_t>;
constexpr std::int64_t kTime_us = 1700000000123456;

link::CanFrame frame(std::uint32_t id, std::initializer_list<std::uint8_t> data) {
  link::CanFrame f{id, static_cast<std::uint8_t>(data.size()), {}};
  std::copy(data.begin(), data.end(), f.data.begin());
  return f;
}

/// A MAVLink 2 packet of that payload; checksums do not matter to a log.
Bytes packet(std::size_t payload, std::uint8_t fill, bool is_signed = false) {
  Bytes p{0xFD,
          static_cast<std::uint8_t>(payload),
          static_cast<std::uint8_t>(is_signed),
          0,
          1,
          1,
          1,
          0,
          0,
          0};
  p.resize(p.size() + payload + 2 + (is_signed ? 13 : 0), fill);
  return p;
}

struct TlogEntry {
  std::int64_t unix_us;
  Bytes packet;
};

/// Fails if the file contains anything but whole records.
std::vector<TlogEntry> read_tlog(const std::filesystem::path& path) {
  const std::string text = content(path);
  std::vector<TlogEntry> entries;
  for (std::size_t at = 0; at < text.size();) {
    REQUIRE(text.size() - at >= 11);
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[at + i]); };
    TlogEntry entry{0, {}};
    for (std::size_t i = 0; i < 8; ++i) entry.unix_us = entry.unix_us << 8U | byte(i);
    REQUIRE(byte(8) == 0xFD);
    const std::size_t size = 12U + byte(9) + (byte(10) == 1 ? 13U : 0U);
    REQUIRE(text.size() - at - 8 >= size);
    for (std::size_t i = 0; i < size; ++i) entry.packet.push_back(byte(8 + i));
    entries.push_back(entry);
    at += 8 + size;
  }
  return entries;
}

/// All files of the directory whose name ends so, in the order of their numbers.
std::vector<std::filesystem::path> files(const std::filesystem::path& folder, const char* ending) {
  std::set<std::filesystem::path> found;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().string().ends_with(ending)) found.insert(entry.path());
  }
  return {found.begin(), found.end()};
}

std::uint64_t total_size(const std::vector<std::filesystem::path>& paths) {
  return std::accumulate(
      paths.begin(), paths.end(), std::uint64_t{0},
      [](auto sum, const auto& path) { return sum + std::filesystem::file_size(path); });
}

TEST_CASE("a CAN frame is a line of candump -L, eight hexadecimal digits for the id") {
  Scratch folder;
  {
    Logs logs({.directory = folder.path(), .can_name = "vcan0"});
    logs.can(frame(0x0704060A, {0xFF, 0x7C, 0x02, 0x00, 0xC1}), kTime_us);
    logs.can(frame(0x1F, {}), kTime_us + 876544);
    logs.can(frame(0x1FFFFFFF, {0, 1, 2, 3, 4, 5, 6, 7}), 7);
  }
  CHECK(content(folder / "can-00001.log") ==
        "(1700000000.123456) vcan0 0704060A#FF7C0200C1\n"
        "(1700000001.000000) vcan0 0000001F#\n"
        "(0000000000.000007) vcan0 1FFFFFFF#0001020304050607\n");
  CHECK(files(folder.path(), ".tlog").empty());
}

TEST_CASE("MAVLink bytes in any chunks are logged packet by packet, each link in its own log") {
  Scratch folder;
  const std::uint32_t seed = 11;
  CAPTURE(seed);
  std::mt19937 random(seed);
  std::vector<Bytes> sent;
  std::size_t chunks = 0;
  {
    Logs logs({.directory = folder.path(), .links = 2});
    Bytes stream;
    for (int i = 0; i < 300; ++i) {
      sent.push_back(packet(random() % 256, static_cast<std::uint8_t>(i), i % 3 == 0));
      stream.insert(stream.end(), sent.back().begin(), sent.back().end());
    }
    for (std::size_t at = 0; at < stream.size();) {
      const std::size_t size = std::min<std::size_t>(random() % 200, stream.size() - at);
      const auto chunk = std::span(stream).subspan(at, size);
      logs.mavlink(0, Direction::kReceived, chunk, kTime_us + static_cast<std::int64_t>(at));
      logs.mavlink(1, Direction::kSent, packet(1, 0xEE), kTime_us);
      at += size;
      ++chunks;
    }
  }
  CHECK(read_tlog(folder / "mavlink1-00001.tlog").size() == chunks);
  std::vector<Bytes> logged;
  std::int64_t last_us = 0;
  for (const auto& entry : read_tlog(folder / "mavlink0-00001.tlog")) {
    CHECK(entry.unix_us >= last_us);
    last_us = entry.unix_us;
    logged.push_back(entry.packet);
  }
  CHECK(logged == sent);
}

TEST_CASE("many packets in one chunk larger than any record are all logged") {
  Scratch folder;
  Bytes many;
  for (int i = 0; i < 100; ++i) {
    const Bytes one = packet(200, static_cast<std::uint8_t>(i));
    many.insert(many.end(), one.begin(), one.end());
  }
  {
    Logs logs({.directory = folder.path(), .links = 64});
    logs.mavlink(63, Direction::kSent, many, kTime_us);
    logs.mavlink(64, Direction::kSent, many, kTime_us);  // no such link: nothing
  }
  CHECK(read_tlog(folder / "mavlink63-00001.tlog").size() == 100);
  CHECK(files(folder.path(), ".tlog").size() == 1);
}

TEST_CASE("noise between packets stays out of the log, MAVLink 1 does not") {
  PacketSplitter splitter;
  std::vector<Bytes> packets;
  const auto feed = [&](const Bytes& bytes) {
    splitter.split(
        bytes, [&](std::span<const std::uint8_t> p) { packets.emplace_back(p.begin(), p.end()); });
  };
  const Bytes v1{0xFE, 1, 0, 1, 1, 0, 42, 9, 9};
  feed({1, 2, 3, 0xFD, 4, 0x80, 7});  // 0xFD with flags that do not exist
  feed(packet(3, 5));
  feed(v1);
  feed(packet(0, 0));
  CHECK(packets == std::vector<Bytes>{packet(3, 5), v1, packet(0, 0)});
}

/// SETUP_SIGNING for 1/1 with the key 0x11 … 0x11, unsigned, as pymavlink packs it.
Bytes setup_signing(bool is_signed) {
  Bytes p{0xFD, 42, static_cast<std::uint8_t>(is_signed), 0, 0, 255, 190, 0, 1, 0};
  p.insert(p.end(), 8, 0);
  p.insert(p.end(), {1, 1});
  p.insert(p.end(), 32, 0x11);
  p.insert(p.end(), is_signed ? 15 : 2, 0x77);
  return p;
}

TEST_CASE("a signing key in transit is in no log, whoever sends it; its neighbours are") {
  Scratch folder;
  const Bytes noise{0xFD, 40, 0};  // swallows most of what follows
  for (const bool is_signed : {false, true}) {
    const Bytes secret = setup_signing(is_signed);
    Logs logs({.directory = folder.path()});
    for (const auto direction : {Direction::kReceived, Direction::kSent}) {
      for (const Bytes& bytes : {packet(9, 1), secret, packet(9, 2), noise, secret, packet(9, 3)}) {
        logs.mavlink(0, direction, std::span(bytes).first(3), kTime_us);
        logs.mavlink(0, direction, std::span(bytes).subspan(3), kTime_us);
      }
    }
  }
  for (const auto& path : files(folder.path(), ".tlog")) {
    CHECK(content(path).find(std::string(8, '\x11')) == std::string::npos);
    std::vector<Bytes> left;
    for (const auto& entry : read_tlog(path)) left.push_back(entry.packet);
    const std::vector<Bytes> once{packet(9, 1), packet(9, 2), packet(9, 3)};
    std::vector<Bytes> twice = once;
    twice.insert(twice.end(), once.begin(), once.end());
    CHECK(left == twice);
    CHECK((std::filesystem::status(path).permissions() & std::filesystem::perms::others_all) ==
          std::filesystem::perms::none);
  }
  CHECK(files(folder.path(), ".tlog").size() == 2);
}

TEST_CASE("a file that is full is followed by the next; all records are there, each whole") {
  Scratch folder;
  {
    Logs logs({.directory = folder.path(), .file_bytes = 1000, .total_bytes = 1000000});
    for (int i = 0; i < 500; ++i) {
      logs.mavlink(0, Direction::kSent, packet(40, 1), kTime_us + i);
      logs.can(frame(static_cast<std::uint32_t>(i), {1, 2, 3}), kTime_us);
    }
  }
  const auto tlogs = files(folder.path(), ".tlog");
  CHECK(tlogs.size() == 32);  // 16 records of 60 bytes are 960
  CHECK(tlogs[1].filename() == "mavlink0-00002.tlog");
  std::int64_t next_us = kTime_us;
  for (const auto& path : tlogs) {
    CHECK(std::filesystem::file_size(path) <= 1000);
    for (const auto& entry : read_tlog(path)) CHECK(entry.unix_us == next_us++);
  }
  CHECK(next_us == kTime_us + 500);
  std::string all;
  for (const auto& path : files(folder.path(), ".log")) {
    CHECK(content(path).ends_with('\n'));
    all += content(path);
  }
  CHECK(std::count(all.begin(), all.end(), '\n') == 500);
}

TEST_CASE("the oldest files are deleted, of this and earlier runs; other files never") {
  Scratch folder;
  put(folder / "mavlink0-x.tlog", "not mine");
  put(folder / "mavlink0-1.tlog", "not mine");
  put(folder / "sailing.tlog", "not mine");
  for (int run = 0; run < 5; ++run) {
    Logs logs({.directory = folder.path(), .file_bytes = 1000, .total_bytes = 4000});
    for (int i = 0; i < 30; ++i)
      logs.mavlink(0, Direction::kSent, packet(40, 1), kTime_us + 100 * run + i);
  }
  for (const char* name : {"mavlink0-x.tlog", "mavlink0-1.tlog", "sailing.tlog"}) {
    CHECK(content(folder / name) == "not mine");
    std::filesystem::remove(folder / name);
  }
  const auto left = files(folder.path(), ".tlog");
  CHECK(left.back().filename() == "mavlink0-00010.tlog");  // two a run
  CHECK(left.size() >= 4);
  CHECK(total_size(left) <= 4000);
  CHECK(read_tlog(left.back()).back().unix_us == kTime_us + 429);
}

TEST_CASE("a ring that is full drops records whole and counts them") {
  Scratch folder;
  LogCounters counters;
  std::uint64_t put = 0;
  {
    Logs logs({.directory = folder.path(), .ring_bytes = 4096});
    while (logs.counters().dropped < 1000) {
      logs.can(frame(static_cast<std::uint32_t>(put++), {1, 2, 3, 4, 5, 6, 7, 8}), kTime_us);
    }
    soon([&] { return logs.counters().written + logs.counters().dropped == put; });
    counters = logs.counters();
    CHECK_FALSE(logs.error());
  }
  CHECK(counters.lost == 0);
  CHECK(counters.written + counters.dropped == put);
  const std::string text = content(folder / "can-00001.log");
  CHECK(static_cast<std::uint64_t>(std::count(text.begin(), text.end(), '\n')) == counters.written);
}

TEST_CASE("a log is readable while it is written") {
  Scratch folder;
  Logs logs({.directory = folder.path()});
  logs.can(frame(1, {2}), kTime_us);
  CHECK(soon([&] { return content(folder / "can-00001.log").ends_with("#02\n"); }));
  CHECK(soon([&] { return logs.counters().written == 1; }));
}

TEST_CASE("a directory that cannot be written to is reported once and counted, the boat sails on") {
  Scratch folder;
  put(folder / "file", "");
  Logs logs({.directory = folder / "file" / "logs"});
  logs.can(frame(1, {2}), kTime_us);
  std::optional<std::string> complaint;
  REQUIRE(soon([&] { return (complaint = logs.error()).has_value(); }));
  CHECK(complaint->find("Not a directory") != std::string::npos);
  logs.mavlink(0, Direction::kSent, packet(1, 1), kTime_us);
  CHECK(soon([&] { return logs.counters().lost == 2; }));
  CHECK_FALSE(logs.error());

  // The fault is repaired: logging continues.
  std::filesystem::remove(folder / "file");
  CHECK(soon([&] {
    logs.can(frame(1, {2}), kTime_us);
    return logs.counters().written > 0;
  }));
}

/// No file of this process may become larger, as on a disk that is full.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, before_.rlim_max};
    REQUIRE(::setrlimit(RLIMIT_FSIZE, &limit) == 0);
  }
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

TEST_CASE("a disk that fills up in the middle of a record leaves whole records behind") {
  Scratch folder;
  LogSeries series{folder.path(), "mavlink", ".tlog", 1000000, 10000000};
  LogFile file(series);
  const Bytes record = [] {
    Bytes r(8);
    const Bytes p = packet(40, 1);
    r.insert(r.end(), p.begin(), p.end());
    return r;
  }();
  for (int i = 0; i < 3; ++i) file.append(record);
  file.flush();
  {
    const FullDisk disk(5 * record.size() + 7);
    for (int i = 0; i < 10; ++i) file.append(record);
    file.flush();
    CHECK(file.lost() == 10);
    file.append(record);
    CHECK(file.lost() == 11);
  }
  CHECK(file.written() == 3);
  REQUIRE(file.fault());
  CHECK(file.fault()->find("mavlink-00001.tlog: File too large") != std::string::npos);
  CHECK(read_tlog(folder / "mavlink-00001.tlog").size() == 3);
  {
    const FullDisk disk(7);
    for (int again = 0; again < 5; ++again) {
      file.try_again();
      file.append(record);
      file.flush();
    }
  }
  CHECK(files(folder.path(), ".tlog").size() == 1);  // no collection of empty files
  file.try_again();
  file.append(record);
  file.close();
  CHECK(read_tlog(folder / "mavlink-00002.tlog").size() == 1);
}

TEST_CASE("killed with SIGKILL: all records written before are there, whole") {
  Scratch folder;
  const pid_t child = ::fork();
  if (child == 0) {
    Logs logs({.directory = folder.path()});
    for (int i = 0; i < 100; ++i) logs.mavlink(0, Direction::kSent, packet(40, 1), kTime_us + i);
    while (logs.counters().written < 100) ::poll(nullptr, 0, 1);
    ::raise(SIGKILL);
  }
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  CHECK(WTERMSIG(status) == SIGKILL);
  CHECK(read_tlog(folder / "mavlink0-00001.tlog").size() == 100);
}

TEST_CASE("no directory, no logs: nothing happens") {
  Logs logs({});
  logs.can(frame(1, {2}), kTime_us);
  logs.mavlink(0, Direction::kSent, packet(1, 1), kTime_us);
  CHECK(logs.counters().dropped == 0);
  CHECK_FALSE(logs.error());
}

TEST_CASE(
    "two threads and a small ring: every record arrives once, whole, in order, or is refused") {
  LogRing ring(512);
  constexpr std::int64_t kRecords = 100000;
  std::int64_t refused = 0;
  std::thread producer([&] {
    Bytes payload;
    for (std::int64_t i = 1; i <= kRecords; ++i) {
      payload.assign(static_cast<std::size_t>(i % 50), static_cast<std::uint8_t>(i));
      const LogRecord record{i, static_cast<std::uint16_t>(payload.size()),
                             static_cast<std::uint8_t>(i % 7)};
      while (!ring.put(record, payload)) {
        ++refused;
        std::this_thread::yield();
      }
    }
  });
  Bytes out(65535);
  std::int64_t bad = 0, last = 0;
  while (last < kRecords) {
    const auto record = ring.take(out);
    if (!record) {
      std::this_thread::yield();
      continue;
    }
    const bool good = record->unix_us == last + 1 && record->size == record->unix_us % 50 &&
                      record->channel == record->unix_us % 7 &&
                      std::all_of(out.begin(), out.begin() + record->size, [&](auto b) {
                        return b == static_cast<std::uint8_t>(record->unix_us);
                      });
    bad += !good;
    last = record->unix_us;
  }
  producer.join();
  CHECK(bad == 0);
  CHECK_FALSE(ring.take(out));
}

TEST_CASE("a record that fits exactly is taken, one byte more is not") {
  LogRing ring(64);
  Bytes payload(64 - sizeof(LogRecord) + 1, 7), out(65535);
  const auto record = [&] { return LogRecord{1, static_cast<std::uint16_t>(payload.size()), 0}; };
  CHECK_FALSE(ring.put(record(), payload));
  payload.pop_back();
  for (int i = 0; i < 10; ++i) {
    CHECK(ring.put(record(), payload));
    CHECK_FALSE(ring.put({1, 0, 0}, {}));
    CHECK(ring.take(out));
    CHECK_FALSE(ring.take(out));
    CHECK(ring.put({1, 0, 0}, {}));  // shifts the next one against the wrap
    CHECK(ring.take(out));
  }
}

TEST_CASE("the candump log calls the bus by its interface") {
  CHECK(candump_name("socketcan:can0") == "can0");
  CHECK(candump_name("mcast:3") == "mcast3");
  CHECK(candump_name("mcast:3:192.168.1.7") == "mcast3");
}

}  // namespace
}  // namespace flotilla::target
