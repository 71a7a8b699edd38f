// SPDX-License-Identifier: MIT
// The boat's plan, fence or rally points on disk, bit for bit as received, with a checksum. The
// first line names the kind, as the file's name does.
//
//   flotilla-plan 1
//   16 6 1 473977420 85455940 00000000 3FC00000 00000000 7FC00000 00000000
//   …
//   crc32 = 89ABCDEF
//
// A line is an item: MAV_CMD, frame, autocontinue, x, y; then parameters 1 to 4 and z, as the bits
// of floats. The file is replaced by a rename, so after a crash it holds the old items or the new
// ones.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "app/plan/plan.hpp"
#include "linux/files/list_saver.hpp"

namespace flotilla::target {

struct LoadedPlan {
  std::vector<app::PlanItem> items;
  std::string note;  ///< for the operator, if the file could not be used; or empty
};

/// Never throws for the content of the disk.
LoadedPlan load_plan(const std::filesystem::path& path);

/// The content of a file of that name with these items.
std::string plan_text(const std::filesystem::path& path, app::Plan plan);

class PlanSaver : public ListSaver<app::PlanItem> {
 public:
  /// Throws std::system_error if the thread cannot be started.
  explicit PlanSaver(const std::filesystem::path& path,
                     std::chrono::milliseconds every = std::chrono::milliseconds(100));
};

}  // namespace flotilla::target
