// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "linux/files/signing_time.hpp"
#include "linux/scratch.hpp"
#include "linux/soon.hpp"

namespace flotilla::target {
namespace {

constexpr std::uint64_t kThen = 37'500'000'000'000;

TEST_CASE("the time of the last voyage is there at the next start") {
  const Scratch folder;
  const auto file = folder / "signing_time.txt";
  {
    SigningTime time(file, kThen);
    time.put(kThen + 77);
    CHECK_FALSE(time.error());
  }
  const StoredSigningTime stored = load_signing_time(file);
  CHECK(stored.timestamp == kThen + 77);
  CHECK(stored.note.empty());
}

TEST_CASE("the time goes to the disk again and again while the boat sails") {
  const Scratch folder;
  const auto file = folder / "signing_time.txt";
  SigningTime time(file, kThen, std::chrono::milliseconds(5));
  for (std::uint64_t now = kThen; now < kThen + 4; ++now) {
    time.put(now);
    CHECK(soon([&] { return load_signing_time(file).timestamp == now; }));
  }
}

TEST_CASE("a first start has no time, and reports no fault") {
  const Scratch folder;
  const StoredSigningTime stored = load_signing_time(folder / "signing_time.txt");
  CHECK(stored.timestamp == 0);
  CHECK(stored.note.empty());
}

TEST_CASE("a file with any bit flipped, or cut anywhere, is reported and not used") {
  const Scratch folder;
  const auto file = folder / "signing_time.txt";
  {
    const SigningTime time(file, kThen);
  }
  const std::string whole = content(file);
  const auto refused = [&](const std::string& text) {
    put(file, text);
    const StoredSigningTime stored = load_signing_time(file);
    return stored.timestamp == 0 && stored.note == "signing_time.txt is damaged; not used";
  };
  for (std::size_t i = 0; i < whole.size(); ++i) {
    CHECK(refused(whole.substr(0, i)));
    for (unsigned bit = 0; bit < 8; ++bit) {
      std::string damaged = whole;
      damaged[i] = static_cast<char>(static_cast<unsigned char>(whole[i]) ^ 1U << bit);
      CAPTURE(i);
      CHECK(refused(damaged));
    }
  }
  CHECK_FALSE(refused(whole));
}

TEST_CASE("a disk that cannot store the time is reported once") {
  const Scratch folder;
  put(folder / "state", "a file, no directory");
  SigningTime time(folder / "state" / "signing_time.txt", kThen);
  std::optional<std::string> complaint;
  REQUIRE(soon([&] { return (complaint = time.error()).has_value(); }));
  CHECK(complaint->find("signing_time.txt.new cannot be written") != std::string::npos);
  CHECK_FALSE(time.error());
}

}  // namespace
}  // namespace flotilla::target
