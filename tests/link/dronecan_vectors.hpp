// SPDX-License-Identifier: MIT
// tests/reference/dronecan_vectors.json, translated by vectors_to_cpp.py when the tests are built.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "link/dronecan/transfer.hpp"

namespace flotilla::vectors {

using Bytes = std::vector<std::uint8_t>;

struct Transfer {
  std::string_view name;
  std::uint32_t can_id;
  std::uint64_t signature;
  std::uint8_t transfer_id;
  std::vector<std::string_view> frames;  ///< hexadecimal, each with its tail byte
  std::string_view payload;
};

struct Damaged {
  std::string_view name;
  std::uint32_t can_id;
  std::uint64_t signature;
  std::vector<std::string_view> frames;
  int delivered;
};

struct Logged {
  std::uint32_t can_id;
  std::uint64_t signature;
  std::string_view frame;
};

/// A payload and its fields in the order of the DSDL.
struct Values {
  std::string_view payload;
  std::vector<double> values;
};

#include "dronecan_vectors.inc"

inline Bytes bytes_of(std::string_view hex) {
  Bytes out;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    out.push_back(static_cast<std::uint8_t>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16)));
  }
  return out;
}

inline link::DataType type_of(const link::Route& route, std::uint64_t signature) {
  return {route.kind, route.type, signature};
}

}  // namespace flotilla::vectors
