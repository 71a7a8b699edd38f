// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <random>
#include <vector>

#include "link/mavlink/crc32.hpp"
#include "linux/files/durable_file.hpp"
#include "linux/files/parameter_file.hpp"
#include "linux/files/saved_parameters.hpp"
#include "linux/scratch.hpp"

namespace flotilla::target {
namespace {

using app::Parameters;

Parameters with_kx(float kx) {
  Parameters p;
  p.LAW_KX = kx;
  return p;
}

/// A boat's directory with two saves behind it: k_x 0.25, then 0.5.
struct Boat {
  Scratch folder;
  std::filesystem::path file = folder / "parameters.txt";
  std::filesystem::path previous = folder / "parameters.txt.previous";

  Boat() {
    REQUIRE_FALSE(save_parameters(file, with_kx(0.25F), {}));
    REQUIRE_FALSE(save_parameters(file, with_kx(0.5F), {}));
  }
};

bool said(const LoadedParameters& loaded, std::string_view words) {
  for (const std::string& note : loaded.notes) {
    if (note.find(words) != std::string::npos) return true;
  }
  return false;
}

/// A file with these lines and a good checksum.
std::string signed_text(const std::string& body) {
  char line[32];
  std::snprintf(line, sizeof line, "crc32 = %08X\n", static_cast<unsigned>(link::ieee_crc32(body)));
  return body + line;
}

TEST_CASE("the checksum is the standard CRC-32") {
  CHECK(link::ieee_crc32("123456789") == 0xCBF43926U);
  CHECK(link::ieee_crc32("") == 0);
}

TEST_CASE("a boat that was never set up has defaults, which an operator must confirm") {
  Scratch folder;
  const auto loaded = load_parameters(folder / "parameters.txt");
  CHECK(loaded.source == ParameterSource::kFirstStart);
  CHECK(loaded.must_be_confirmed);
  REQUIRE(loaded.notes.size() == 2);
  CHECK(loaded.notes[0].ends_with("parameters.txt: never set up, or lost"));
  CHECK(loaded.values.LAW_KX == Parameters{}.LAW_KX);
}

TEST_CASE("every value comes back to the last bit") {
  Scratch folder;
  std::mt19937 random(7);
  for (int round = 0; round < 50; ++round) {
    Parameters p;
    for (const auto& info : app::kParameterList) {
      std::uniform_real_distribution<float> any(info.least, info.greatest);
      const float value = any(random);
      if (!info.whole() && app::is_valid(info, value)) p.*info.member = value;
    }
    if (app::contradiction(p)) continue;
    REQUIRE_FALSE(save_parameters(folder / "p", p, {}));
    const auto loaded = load_parameters(folder / "p");
    CHECK(loaded.source == ParameterSource::kFile);
    CHECK(loaded.notes.empty());
    for (const auto& info : app::kParameterList) {
      CAPTURE(info.name);
      CHECK(loaded.values.*info.member == p.*info.member);
    }
  }
}

TEST_CASE("the file reads like a list and its directory is made where it is missing") {
  Scratch folder;
  const auto file = folder / "deep" / "down" / "parameters.txt";
  REQUIRE_FALSE(save_parameters(file, with_kx(0.1F), {}));
  const std::string text = content(file);
  CHECK(text.starts_with("flotilla-parameters 1\n"));
  CHECK(text.find("\nLAW_KX = 0.1\n") != std::string::npos);
  CHECK(text.find("\nMAV_SYSID = 1\n") != std::string::npos);
}

TEST_CASE("file truncated at any byte: the previous version is used and reported") {
  Boat boat;
  const std::string whole = content(boat.file);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    CAPTURE(size);
    put(boat.file, whole.substr(0, size));
    const auto loaded = load_parameters(boat.file);
    CHECK(loaded.source == ParameterSource::kPrevious);
    CHECK(loaded.values.LAW_KX == 0.25F);
    CHECK(said(loaded, "parameters.txt "));
    CHECK(said(loaded, "parameters loaded from parameters.txt.previous"));
    CHECK(loaded.must_be_confirmed);
  }
}

TEST_CASE("any single bit of the file flipped: the previous version is used and reported") {
  Boat boat;
  const std::string whole = content(boat.file);
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    CAPTURE(bit);
    std::string damaged = whole;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << bit % 8));
    put(boat.file, damaged);
    const auto loaded = load_parameters(boat.file);
    CHECK(loaded.source == ParameterSource::kPrevious);
    CHECK(loaded.values.LAW_KX == 0.25F);
    CHECK(said(loaded, "checksum"));
  }
}

TEST_CASE("both versions damaged, or one damaged and no other: defaults, to be confirmed") {
  Boat boat;
  const std::string whole = content(boat.file);
  bool previous_is_gone = false;
  SUBCASE("the previous one is damaged too") { put(boat.previous, whole.substr(0, 22)); }
  SUBCASE("there is no previous one") {
    previous_is_gone = std::filesystem::remove(boat.previous);
    REQUIRE(previous_is_gone);
  }
  for (std::size_t size = 0; size < whole.size(); ++size) {
    CAPTURE(size);
    put(boat.file, whole.substr(0, size));
    const auto loaded = load_parameters(boat.file);
    CHECK(loaded.source == ParameterSource::kDefaults);
    CHECK(loaded.values.LAW_KX == Parameters{}.LAW_KX);
    CHECK(loaded.must_be_confirmed);
    CHECK(said(loaded, "ALL PARAMETERS ARE DEFAULTS"));
    CHECK(said(loaded, "parameters.txt.previous") == !previous_is_gone);
  }
}

TEST_CASE("anything else in place of a parameter file is reported, and never fatal") {
  Boat boat;
  std::filesystem::remove(boat.previous);
  std::filesystem::remove(boat.file);
  std::string why;
  SUBCASE("a directory") {
    std::filesystem::create_directory(boat.file);
    why = "cannot be read: Is a directory";
  }
  SUBCASE("an endless file") {
    std::filesystem::create_symlink("/dev/zero", boat.file);
    why = "cannot be read";
  }
  SUBCASE("a huge file") {
    put(boat.file, std::string(2U << 20U, 'x'));
    why = "cannot be read: File too large";
  }
  SUBCASE("an undamaged file of another kind") {
    put(boat.file, signed_text("shopping list\nbeer = 6\n"));
    why = "is not a parameter file";
  }
  SUBCASE("a future format") {
    put(boat.file, signed_text("flotilla-parameters 2\nLAW_KX = 0.5\n"));
    why = "has another format (\"flotilla-parameters 2\")";
  }
  SUBCASE("noise") {
    std::mt19937 random(3);
    std::string noise(500, '\0');
    for (char& c : noise) c = static_cast<char>(random());
    put(boat.file, noise);
    why = "checksum";
  }
  const auto loaded = load_parameters(boat.file);
  CHECK(loaded.source == ParameterSource::kDefaults);
  CHECK(said(loaded, why));
}

TEST_CASE("beside a file of another format, the previous version is old: it must be confirmed") {
  Boat boat;
  put(boat.file, signed_text("flotilla-parameters 2\nLAW_KX = 0.75\n"));
  const auto loaded = load_parameters(boat.file);
  CHECK(loaded.source == ParameterSource::kPrevious);
  CHECK(loaded.values.LAW_KX == 0.25F);
  CHECK(loaded.must_be_confirmed);
  CHECK(said(loaded, "has another format (\"flotilla-parameters 2\")"));
}

TEST_CASE("at exit, the previous version replaces no file unless an operator has saved") {
  for (const std::string& other :
       {signed_text("flotilla-parameters 2\n"), std::string("damaged, or edited by hand")}) {
    Boat boat;
    put(boat.file, other);
    {
      SavedParameters saved(boat.file);
      saved.begin(saved.values());
      CHECK(saved.finish(app::SaveRequest::kNone, saved.values()).empty());
    }
    CHECK(content(boat.file) == other);
    SavedParameters saved(boat.file);
    saved.begin(saved.values());
    CHECK(saved.finish(app::SaveRequest::kConfirmed, saved.values()).size() == 1);
    CHECK(load_parameters(boat.file).source == ParameterSource::kFile);
    CHECK(load_parameters(boat.file).values.LAW_KX == 0.25F);
  }
}

TEST_CASE("a value that is not allowed keeps its default alone, and must be confirmed") {
  Scratch folder;
  for (const std::string bad :
       {"nan", "inf", "-inf", "9", "-0.1", "1e39", "1e-50x", "", "0.5 ", "0x1"}) {
    CAPTURE(bad);
    put(folder / "p",
        signed_text("flotilla-parameters 1\nLAW_KX = " + bad + "\nLAW_KPSI = 0.75\n"));
    const auto loaded = load_parameters(folder / "p");
    CHECK(loaded.source == ParameterSource::kFile);
    CHECK(loaded.values.LAW_KX == Parameters{}.LAW_KX);
    CHECK(loaded.values.LAW_KPSI == 0.75F);
    CHECK(loaded.must_be_confirmed);
    CHECK(said(loaded,
               "p: LAW_KX = " + bad + " is refused (allowed: 0 to 2); using the default 0.2"));
  }
}

TEST_CASE("values that exclude each other: the previous version is used") {
  Boat boat;
  put(boat.file, signed_text("flotilla-parameters 1\nESC_PORT = 3\nESC_STBD = 3\n"));
  const auto loaded = load_parameters(boat.file);
  CHECK(loaded.source == ParameterSource::kPrevious);
  CHECK(loaded.values.LAW_KX == 0.25F);
  CHECK(loaded.values.ESC_PORT == 0);
  CHECK(said(loaded, "is inconsistent: ESC_PORT and ESC_STBD are the same ESC"));
}

TEST_CASE("names of another version are kept over saves, word for word, and reported") {
  Scratch folder;
  put(folder / "p", signed_text("flotilla-parameters 1\nLAW_KX = 0.5\nLAW_MAGIC = 3.25\n"
                                "no equals sign\nLAW_KPSI=1\n"));
  auto loaded = load_parameters(folder / "p");
  for (int save = 0; save < 3; ++save) {
    CHECK(loaded.source == ParameterSource::kFile);
    CHECK(loaded.values.LAW_KX == 0.5F + 0.125F * static_cast<float>(save));
    REQUIRE(loaded.unknown.size() == 3);
    CHECK(loaded.unknown[0] == "LAW_MAGIC = 3.25");
    CHECK(loaded.unknown[1] == "no equals sign");
    CHECK(loaded.unknown[2] == "LAW_KPSI=1");
    CHECK(said(loaded, "p: \"LAW_MAGIC\" is unknown to this version and kept"));
    CHECK_FALSE(loaded.must_be_confirmed);
    loaded.values.LAW_KX += 0.125F;
    REQUIRE_FALSE(save_parameters(folder / "p", loaded.values, loaded.unknown));
    loaded = load_parameters(folder / "p");
  }
}

TEST_CASE("a file of an older version is read; missing values are defaults and reported") {
  Scratch folder;
  put(folder / "p", signed_text("flotilla-parameters 1\nLAW_KX = 0.5\n"));
  const auto loaded = load_parameters(folder / "p");
  CHECK(loaded.source == ParameterSource::kFile);
  CHECK(loaded.values.LAW_KX == 0.5F);
  CHECK(loaded.values.LAW_KPSI == Parameters{}.LAW_KPSI);
  CHECK_FALSE(loaded.must_be_confirmed);
  REQUIRE(loaded.notes.size() == 1);
  CHECK(loaded.notes[0].starts_with("p: not in the file, so default: MAV_SYSID, "));
}

TEST_CASE("zeros that were defaults in an older version become the new defaults") {
  Scratch folder;
  const std::string old = "flotilla-parameters 1\nNAV_LAG_S = 0\nFS_SEP_M = 0\n";
  put(folder / "old", signed_text(old));
  const auto loaded = load_parameters(folder / "old");
  CHECK(loaded.values.NAV_LAG_S == -1);
  CHECK(loaded.values.FS_SEP_M == -1);
  CHECK(said(loaded, "old: NAV_LAG_S = 0 from an older version is replaced by the new default -1"));
  put(folder / "new", signed_text(old + "NAV_COMPID = 0\n"));
  CHECK(load_parameters(folder / "new").values.NAV_LAG_S == 0);
  CHECK(load_parameters(folder / "new").values.FS_SEP_M == 0);
  put(folder / "set", signed_text("flotilla-parameters 1\nNAV_LAG_S = 0.2\nFS_SEP_M = 2\n"));
  CHECK(load_parameters(folder / "set").values.NAV_LAG_S == 0.2F);
  CHECK(load_parameters(folder / "set").values.FS_SEP_M == 2);
}

TEST_CASE("an old file with a mode is read with a message, and loses it when it is saved") {
  Scratch folder;
  put(folder / "p", signed_text("flotilla-parameters 1\nMODE = 6\nLAW_KX = 0.5\n"));
  const auto loaded = load_parameters(folder / "p");
  CHECK(loaded.source == ParameterSource::kFile);
  CHECK(loaded.values.LAW_KX == 0.5F);
  CHECK(loaded.unknown.empty());
  CHECK_FALSE(loaded.must_be_confirmed);
  CHECK(said(
      loaded,
      "p: MODE = 6 is ignored: the mode is no longer a parameter, set it from the ground station"));
  REQUIRE_FALSE(save_parameters(folder / "p", loaded.values, loaded.unknown));
  CHECK(content(folder / "p").find("\nMODE") == std::string::npos);
}

TEST_CASE("saving unchanged values leaves both versions alone") {
  Boat boat;
  REQUIRE_FALSE(save_parameters(boat.file, with_kx(0.5F), {}));
  CHECK(load_parameters(boat.file).values.LAW_KX == 0.5F);
  CHECK(load_parameters(boat.previous).values.LAW_KX == 0.25F);
}

TEST_CASE("a save over a damaged file keeps the whole previous version") {
  Boat boat;
  put(boat.file, content(boat.file).substr(0, 100));
  REQUIRE_FALSE(save_parameters(boat.file, with_kx(0.75F), {}));
  CHECK(load_parameters(boat.file).values.LAW_KX == 0.75F);
  CHECK(load_parameters(boat.previous).values.LAW_KX == 0.25F);
}

/// The disk after each step of a save of k_x = 0.75 in a directory like Boat's, as replace_file()
/// leaves it: the file beside half written, whole, renamed; first for the previous version, then
/// for the file.
std::vector<std::function<void(const Boat&)>> steps_of_a_save() {
  const std::string old = parameter_text(with_kx(0.5F), {}),
                    fresh = parameter_text(with_kx(0.75F), {});
  std::vector<std::function<void(const Boat&)>> steps{[](const Boat&) {}};
  const auto then = [&](std::function<void(const Boat&)> next) {
    steps.push_back([before = steps.back(), next](const Boat& boat) {
      before(boat);
      next(boat);
    });
  };
  for (const bool is_previous : {true, false}) {
    const std::string text = is_previous ? old : fresh;
    const auto target = [is_previous](const Boat& b) { return is_previous ? b.previous : b.file; };
    for (std::size_t size = 0; size <= text.size(); size += is_previous ? 61 : 17) {
      then([=](const Boat& b) { put(beside(target(b), ".new"), text.substr(0, size)); });
    }
    then([=](const Boat& b) { put(beside(target(b), ".new"), text); });
    then([=](const Boat& b) { std::filesystem::rename(beside(target(b), ".new"), target(b)); });
  }
  return steps;
}

TEST_CASE(
    "killed between any two steps of a save: the old values or the new, both versions whole") {
  const auto steps = steps_of_a_save();
  for (std::size_t i = 0; i < steps.size(); ++i) {
    CAPTURE(i);
    Boat boat;
    steps[i](boat);
    const auto loaded = load_parameters(boat.file);
    CHECK(loaded.source == ParameterSource::kFile);
    CHECK(loaded.values.LAW_KX == (i + 1 == steps.size() ? 0.75F : 0.5F));
    CHECK(loaded.notes.empty());
    CHECK(load_parameters(boat.previous).source == ParameterSource::kFile);

    // Then the disk also loses the file: still no defaults.
    std::filesystem::remove(boat.file);
    const auto without = load_parameters(boat.file);
    CHECK(without.source == ParameterSource::kPrevious);
    CHECK(said(without, "parameters.txt is missing"));

    // The next save succeeds, whatever files were left.
    REQUIRE_FALSE(save_parameters(boat.file, with_kx(1), {}));
    CHECK(load_parameters(boat.file).values.LAW_KX == 1);
    CHECK(load_parameters(boat.previous).source == ParameterSource::kFile);
  }
}

TEST_CASE("the simulated steps of a save leave the same files as a save") {
  Boat real, simulated;
  REQUIRE_FALSE(save_parameters(real.file, with_kx(0.75F), {}));
  steps_of_a_save().back()(simulated);
  CHECK(content(real.file) == content(simulated.file));
  CHECK(content(real.previous) == content(simulated.previous));
  CHECK_FALSE(std::filesystem::exists(beside(real.file, ".new")));
  CHECK_FALSE(std::filesystem::exists(beside(real.previous, ".new")));
}

TEST_CASE("a failed save reports why and leaves the files as they were") {
  Boat boat;
  std::filesystem::create_directory(beside(boat.file, ".new"));
  const auto fault = save_parameters(boat.file, with_kx(0.75F), {});
  REQUIRE(fault);
  CHECK(fault->find("parameters.txt.new cannot be written: Is a directory") != std::string::npos);
  CHECK(load_parameters(boat.file).values.LAW_KX == 0.5F);
  CHECK(save_parameters("/dev/null/p", with_kx(0.75F), {}));
}

TEST_CASE("full disk: the save reports it, both versions stay") {
  Boat boat;
  std::filesystem::create_symlink("/dev/full", beside(boat.file, ".new"));
  const auto fault = save_parameters(boat.file, with_kx(0.75F), {});
  REQUIRE(fault);
  CHECK(fault->find("No space left on device") != std::string::npos);
  CHECK(load_parameters(boat.file).values.LAW_KX == 0.5F);
}

}  // namespace
}  // namespace flotilla::target
