// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "linux/files/plan_file.hpp"
#include "linux/scratch.hpp"
#include "linux/soon.hpp"

namespace flotilla::target {
namespace {

std::vector<app::PlanItem> plan() {
  app::PlanItem item{{1.5F, -0.0F, 1e-44F, NAN}, 473'977'420, -85'455'940, 0.1F, 16, 6, 1};
  std::vector<app::PlanItem> items{item};
  item.param[0] = std::bit_cast<float>(0xFFC0'1234U);  // a NaN with something in it
  item.x = std::numeric_limits<std::int32_t>::min();
  item.command = 65535;
  item.frame = item.autocontinue = 255;
  items.push_back(item);
  return items;
}

/// Each file, and the text if it is missing.
struct Named {
  const char* file;
  std::string lack;
};
const std::array kEach{Named{"plan.txt", "no plan"}, Named{"fence.txt", "no fence"},
                       Named{"rally.txt", "no rally points"}};

bool same(const std::vector<app::PlanItem>& a, const std::vector<app::PlanItem>& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), a.size() * sizeof(app::PlanItem)) == 0;
}

TEST_CASE("saved plans are there at the next start, bit for bit, each in its own file") {
  const Scratch folder;
  for (const auto& [name, lack] : kEach) {
    const auto file = folder / name;
    {
      PlanSaver saver(file);
      CHECK(saver.put(plan()));
    }
    CHECK(same(load_plan(file).items, plan()));
    CHECK(load_plan(file).note.empty());
  }
  std::filesystem::rename(folder / "fence.txt", folder / "plan.txt");
  CHECK(load_plan(folder / "plan.txt").note == "plan.txt is damaged; no plan");  // of a fence
}

TEST_CASE("a plan goes to the disk while the boat sails, and a cleared one too") {
  const Scratch folder;
  const auto file = folder / "plan.txt";
  PlanSaver saver(file, std::chrono::milliseconds(5));
  CHECK(soon([&] { return saver.put(plan()); }));
  CHECK(soon([&] { return same(load_plan(file).items, plan()); }));
  CHECK(soon([&] { return saver.put({}); }));
  CHECK(soon([&] { return load_plan(file).items.empty(); }));
  CHECK(load_plan(file).note.empty());
  CHECK_FALSE(saver.error());
}

TEST_CASE("a first start has no plan, and reports no fault") {
  const Scratch folder;
  CHECK(load_plan(folder / "plan.txt").items.empty());
  CHECK(load_plan(folder / "plan.txt").note.empty());
}

TEST_CASE("a file that is cut anywhere, or has any bit flipped, is no plan") {
  for (const auto& [name, lack] : kEach) {
    const Scratch folder;
    const auto file = folder / name;
    const std::string whole = plan_text(file, plan());
    const auto refused = [&](const std::string& text) {
      put(file, text);
      const LoadedPlan loaded = load_plan(file);
      return loaded.items.empty() && loaded.note == std::string(name) + " is damaged; " + lack;
    };
    for (std::size_t i = 0; i < whole.size(); ++i) {
      CAPTURE(i);
      CHECK(refused(whole.substr(0, i)));
      for (unsigned bit = 0; bit < 8; ++bit) {
        std::string damaged = whole;
        damaged[i] = static_cast<char>(static_cast<unsigned char>(whole[i]) ^ 1U << bit);
        CHECK(refused(damaged));
      }
    }
    CHECK(refused(whole + "x"));
  }
}

TEST_CASE("power that is cut while a plan is written leaves the old one") {
  const Scratch folder;
  const auto file = folder / "plan.txt";
  put(file, plan_text(file, plan()));
  const std::string next = plan_text(file, app::Plan(plan()).first(1));
  for (std::size_t i = 0; i <= next.size(); ++i) {
    put(folder / "plan.txt.new", next.substr(0, i));  // before the rename
    CHECK(same(load_plan(file).items, plan()));
  }
  PlanSaver saver(file, std::chrono::milliseconds(5));
  const auto one = std::vector(1, plan()[0]);
  CHECK(soon([&] { return saver.put(one); }));
  CHECK(soon([&] { return same(load_plan(file).items, one); }));
}

TEST_CASE("a plan that cannot be written is reported once, and written when possible") {
  const Scratch folder;
  const auto file = folder / "there" / "plan.txt";
  put(folder / "there", "a file where a directory should be");
  PlanSaver saver(file, std::chrono::milliseconds(5));
  CHECK(soon([&] { return saver.put(plan()); }));
  CHECK(soon([&] { return saver.error().has_value(); }));
  std::filesystem::remove(folder / "there");
  CHECK(soon([&] { return same(load_plan(file).items, plan()); }));
  CHECK_FALSE(saver.error());
}

}  // namespace
}  // namespace flotilla::target
