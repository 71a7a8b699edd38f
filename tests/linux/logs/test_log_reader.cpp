// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "linux/logs/log_reader.hpp"
#include "linux/scratch.hpp"

namespace flotilla::target {
namespace {

namespace fs = std::filesystem;

void put(const fs::path& file, const std::string& content, int age_s) {
  std::ofstream(file, std::ios::binary) << content;
  fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::seconds(age_s));
}

LogReader::Answer answer_to(LogReader& reader, const LogReader::Request& request) {
  reader.ask(request);
  for (;;) {
    if (const auto answer = reader.take()) return *answer;
    std::this_thread::yield();
  }
}

std::string read(LogReader& reader, std::size_t log, std::uint32_t offset, std::size_t bytes) {
  const auto got = answer_to(reader, {false, log, offset, bytes}).bytes;
  return {got.begin(), got.end()};
}

TEST_CASE("logs are listed by their age, and no other file is") {
  const Scratch folder;
  put(folder / "mavlink0-00002.tlog", "newest", 10);
  put(folder / "can-00007.log", "middle!", 20);
  put(folder / "mavlink0-00001.tlog", "old", 30);
  put(folder / "secret.txt", "no log", 1);
  put(folder / "can-00008.tlog.gz", "none either", 1);
  fs::create_directory(folder / "mavlink0-9.tlog");
  LogReader reader(folder.path());
  const auto answer = answer_to(reader, {true, 0, 0, 0});
  std::vector<std::string> names;
  for (const LogReader::Log& log : answer.logs) names.push_back(log.file.filename().string());
  CHECK(names ==
        std::vector<std::string>{"mavlink0-00001.tlog", "can-00007.log", "mavlink0-00002.tlog"});
  CHECK(answer.logs[1].size == 7);
  const auto now_s = std::chrono::system_clock::now().time_since_epoch() / std::chrono::seconds(1);
  CHECK(std::abs(now_s - 20 - std::int64_t{answer.logs[1].time_s}) < 5);
}

TEST_CASE("a log is read from anywhere, to its end and no further") {
  const Scratch folder;
  put(folder / "can-00001.log", "0123456789", 5);
  LogReader reader(folder.path());
  answer_to(reader, {true, 0, 0, 0});
  CHECK(read(reader, 0, 0, 4) == "0123");
  CHECK(read(reader, 0, 7, 90) == "789");
  CHECK(read(reader, 0, 10, 90).empty());
  CHECK(read(reader, 0, 4'000'000'000, 90).empty());
  CHECK(read(reader, 1, 0, 90).empty());
  fs::remove(folder / "can-00001.log");
  CHECK(read(reader, 0, 0, 90).empty());
}

TEST_CASE("a missing directory has no logs, and each answer is given once") {
  LogReader reader("/nowhere/at/all");
  CHECK(answer_to(reader, {true, 0, 0, 0}).logs.empty());
  CHECK_FALSE(reader.take());
}

}  // namespace
}  // namespace flotilla::target
