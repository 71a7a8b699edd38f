// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/stat.h>

#include "linux/files/node_table.hpp"
#include "linux/scratch.hpp"
#include "linux/soon.hpp"
#include "linux/system/file_descriptor.hpp"

namespace flotilla::target {
namespace {

constexpr std::chrono::milliseconds kOften(5);

link::NodeIdServer with_one_node() {
  link::NodeIdServer server(20);
  REQUIRE(server.restore({{1, 2, 3}, 77}));
  return server;
}

TEST_CASE("the loop does not wait for a failing disk, and node ids are saved later") {
  const Scratch folder;
  const auto file = folder / "node_ids.txt", fresh = folder / "node_ids.txt.new";
  REQUIRE(::mkfifo(fresh.c_str(), 0600) == 0);  // opening it waits for a reader
  NodeTable table(file, kOften);
  CHECK(soon([&] { return table.save(with_one_node()); }));
  CHECK(soon([&] { return table.save(with_one_node()); }));
  CHECK_FALSE(std::filesystem::exists(file));

  const FileDescriptor reader(::open(fresh.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  std::optional<std::string> complaint;
  CHECK(soon([&] { return (complaint = table.error()).has_value(); }));  // a pipe is no disk
  CHECK(complaint->find("node_ids.txt.new cannot be written") != std::string::npos);
  std::filesystem::remove(fresh);
  CHECK(soon([&] { return std::filesystem::exists(file); }));
  CHECK_FALSE(table.error());
  link::NodeIdServer again(20);
  table.load(again);
  REQUIRE(again.table().size() == 1);
  CHECK(again.table()[0].node == 77);
}

TEST_CASE("node ids assigned at the last moment are saved before exit") {
  const Scratch folder;
  const auto file = folder / "node_ids.txt";
  {
    NodeTable table(file);
    CHECK(soon([&] { return table.save(with_one_node()); }));
  }
  CHECK(content(file) == "01020300000000000000000000000000 77\n");
}

}  // namespace
}  // namespace flotilla::target
