// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/stat.h>

#include <thread>

#include "linux/files/parameter_file.hpp"
#include "linux/files/parameter_saver.hpp"
#include "linux/scratch.hpp"
#include "linux/system/file_descriptor.hpp"

namespace flotilla::target {
namespace {

using app::SaveRequest;

app::Parameters with_kx(float kx) {
  app::Parameters p;
  p.LAW_KX = kx;
  return p;
}

ParameterSaver::Saved outcome_of(ParameterSaver& saver) {
  for (;;) {
    if (auto saved = saver.outcome()) return *std::move(saved);
    std::this_thread::yield();
  }
}

TEST_CASE("values are saved outside the loop and the result is reported once") {
  Scratch folder;
  ParameterSaver saver(folder / "p", {"LAW_MAGIC = 7"});
  CHECK_FALSE(saver.outcome());
  for (const float kx : {0.25F, 0.5F, 0.75F}) {
    REQUIRE(saver.save(with_kx(kx), SaveRequest::kChanged));
    const auto saved = outcome_of(saver);
    CHECK(saved.why == SaveRequest::kChanged);
    CHECK_FALSE(saved.fault);
    CHECK_FALSE(saver.outcome());
    const auto loaded = load_parameters(folder / "p");
    CHECK(loaded.values.LAW_KX == kx);
    CHECK(loaded.unknown == std::vector<std::string>{"LAW_MAGIC = 7"});
  }
}

TEST_CASE("a hanging disk does not block the loop, and the next save follows") {
  Scratch folder;
  // A pipe without a reader: open() waits, as on a failing disk.
  const auto pipe = folder / "p.new";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  ParameterSaver saver(folder / "p", {});
  REQUIRE(saver.save(with_kx(0.25F), SaveRequest::kConfirmed));
  CHECK_FALSE(saver.save(with_kx(0.5F), SaveRequest::kChanged));
  CHECK_FALSE(saver.outcome());

  const FileDescriptor reader(::open(pipe.c_str(), O_RDONLY));
  CHECK(outcome_of(saver).why == SaveRequest::kConfirmed);
  std::filesystem::remove(pipe);
  REQUIRE(saver.save(with_kx(0.5F), SaveRequest::kChanged));
  CHECK_FALSE(outcome_of(saver).fault);
  CHECK(load_parameters(folder / "p").values.LAW_KX == 0.5F);
}

TEST_CASE("a disk that refuses writes is reported in a sentence, and the next save is tried") {
  Scratch folder;
  std::filesystem::create_directory(folder / "p.new");
  ParameterSaver saver(folder / "p", {});
  REQUIRE(saver.save(with_kx(0.25F), SaveRequest::kConfirmed));
  const auto saved = outcome_of(saver);
  REQUIRE(saved.fault);
  CHECK(saved.fault->find("cannot be written") != std::string::npos);
  std::filesystem::remove(folder / "p.new");
  REQUIRE(saver.save(with_kx(0.25F), SaveRequest::kConfirmed));
  CHECK_FALSE(outcome_of(saver).fault);
}

TEST_CASE("at the end the save under way is finished, and its result still reported") {
  Scratch folder;
  for (int i = 0; i < 50; ++i) {
    const float kx = 0.01F * static_cast<float>(i + 1);
    ParameterSaver saver(folder / "p", {});
    REQUIRE(saver.save(with_kx(kx), SaveRequest::kChanged));
    saver.finish();
    CHECK(load_parameters(folder / "p").values.LAW_KX == kx);
    CHECK(saver.outcome());
    CHECK_FALSE(saver.outcome());
  }
}

TEST_CASE("a saver that was never used ends at once") {
  for (int i = 0; i < 50; ++i) ParameterSaver("/nowhere/p", {});
}

}  // namespace
}  // namespace flotilla::target
