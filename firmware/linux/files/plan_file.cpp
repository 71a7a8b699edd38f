// SPDX-License-Identifier: MIT
#include "linux/files/plan_file.hpp"

#include <array>
#include <bit>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "linux/files/durable_file.hpp"

namespace flotilla::target {
namespace {

constexpr std::size_t kMaxItems = 1000;

std::string title_of(const std::filesystem::path& path) {
  return "flotilla-" + path.stem().string() + " 1\n";
}

/// "no plan", "no fence", "no rally points".
std::string none_of(const std::filesystem::path& path) {
  const std::string stem = path.stem().string();
  return "no " + stem + (stem == "rally" ? " points" : "");
}

std::string line_of(const app::PlanItem& item) {
  std::array<char, 128> line{};
  const auto bits = [](float x) { return static_cast<unsigned>(std::bit_cast<std::uint32_t>(x)); };
  std::snprintf(line.data(), line.size(), "%u %u %u %d %d %08X %08X %08X %08X %08X\n",
                unsigned{item.command}, unsigned{item.frame}, unsigned{item.autocontinue}, item.x,
                item.y, bits(item.param[0]), bits(item.param[1]), bits(item.param[2]),
                bits(item.param[3]), bits(item.z));
  return line.data();
}

app::PlanItem item_of(const std::string& line) {
  unsigned command = 0, frame = 0, autocontinue = 0;
  std::array<unsigned, 5> bits{};
  app::PlanItem item;
  // Does not check the line: load_plan() compares the file with the text that its items would give.
  (void)std::sscanf(line.c_str(), "%u %u %u %d %d %8X %8X %8X %8X %8X", &command, &frame,
                    &autocontinue, &item.x, &item.y, &bits[0], &bits[1], &bits[2], &bits[3],
                    &bits[4]);
  item.command = static_cast<std::uint16_t>(command);
  item.frame = static_cast<std::uint8_t>(frame);
  item.autocontinue = static_cast<std::uint8_t>(autocontinue);
  for (std::size_t i = 0; i < 4; ++i) item.param[i] = std::bit_cast<float>(bits[i]);
  item.z = std::bit_cast<float>(bits[4]);
  return item;
}

}  // namespace

std::string plan_text(const std::filesystem::path& path, app::Plan plan) {
  std::string body = title_of(path);
  for (const app::PlanItem& item : plan) body += line_of(item);
  return body + checksum_line(body);
}

LoadedPlan load_plan(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  const FileContent content = read_file(path);
  if (content.error == ENOENT) return {};
  if (content.error != 0) {
    return {{}, name + " cannot be read: " + std::strerror(content.error) + "; " + none_of(path)};
  }
  LoadedPlan loaded;
  std::size_t at = title_of(path).size();
  for (std::size_t end; (end = content.text.find('\n', at)) != std::string::npos; at = end + 1) {
    const std::string line = content.text.substr(at, end - at);
    if (line.starts_with("crc32") || loaded.items.size() >= kMaxItems) break;
    loaded.items.push_back(item_of(line));
  }
  if (content.text != plan_text(path, loaded.items))
    return {{}, name + " is damaged; " + none_of(path)};
  return loaded;
}

PlanSaver::PlanSaver(const std::filesystem::path& path, std::chrono::milliseconds every)
    : ListSaver(
          path, kMaxItems, [path](app::Plan plan) { return plan_text(path, plan); }, every,
          "a plan's saver") {}

}  // namespace flotilla::target
