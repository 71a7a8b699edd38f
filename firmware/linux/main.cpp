// SPDX-License-Identifier: MIT
// flotillad: the autopilot as a program for a Linux companion computer.
#include <unistd.h>

#include <cstdio>
#include <exception>
#include <span>
#include <variant>

#include "linux/config/config.hpp"
#include "linux/loop.hpp"

int main(int argc, char** argv) {
  using namespace flotilla::target;
  const std::span<const char* const> arguments(argv, static_cast<std::size_t>(argc));
  const auto read = read_config(arguments, ::geteuid() == 0);
  if (const auto* ending = std::get_if<Ending>(&read)) {
    std::fputs(ending->text.c_str(), ending->status == 0 ? stdout : stderr);
    return ending->status;
  }
  try {
    return Loop(std::get<Config>(read)).run();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "flotillad: %s\n", error.what());
    return 2;
  }
}
