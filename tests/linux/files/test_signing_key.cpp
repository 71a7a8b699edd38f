// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <stdexcept>

#include "linux/files/signing_key.hpp"
#include "linux/scratch.hpp"

namespace flotilla::target {
namespace {

struct KeyFile {
  Scratch folder;
  std::filesystem::path path = folder / "key";

  explicit KeyFile(const std::string& text, mode_t mode = 0600) {
    put(path, text);
    REQUIRE(::chmod(path.c_str(), mode) == 0);
  }
  std::string refusal() const {
    try {
      read_signing_key(path);
    } catch (const std::runtime_error& error) {
      const std::string text = error.what(), start = "signing-key " + path.string() + " ";
      REQUIRE(text.starts_with(start));
      return text.substr(start.size());
    }
    return {};
  }
};

std::string raw_key() {
  std::string bytes(32, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(0xE5 + i);
  return bytes;
}

const std::string kHex = "e5e6e7e8e9eaebecedeeeff0f1f2f3f4F5F6F7F8F9FAFBFCFDFEFF0001020304";

TEST_CASE("a key is 32 bytes, or 64 digits, perhaps with a newline") {
  const link::SigningKey key = read_signing_key(KeyFile(raw_key()).path);
  CHECK(key[0] == 0xE5);
  CHECK(key[31] == 0x04);
  CHECK(read_signing_key(KeyFile(kHex).path) == key);
  CHECK(read_signing_key(KeyFile(kHex + "\n").path) == key);
  CHECK(read_signing_key(KeyFile(raw_key(), 0400).path) == key);
  CHECK(read_signing_key(KeyFile(raw_key(), 0700).path) == key);
}

TEST_CASE("neither another length nor other digits are a key") {
  const std::string bad[] = {"",
                             raw_key().substr(1),
                             raw_key() + "x",
                             kHex.substr(1),
                             kHex + "00",
                             kHex + "\n\n",
                             kHex + "x",
                             " " + kHex,
                             kHex + "\r\n",
                             "g" + kHex.substr(1),
                             "-" + kHex.substr(1)};
  for (const std::string& text : bad) {
    CAPTURE(text);
    CHECK(KeyFile(text).refusal() == "is not a key (allowed: 32 bytes, or 64 hexadecimal digits)");
  }
}

TEST_CASE("32 hexadecimal digits are half of a key, not a key of 32 bytes") {
  for (const std::string& half : {kHex.substr(0, 32), kHex.substr(32), kHex.substr(0, 31) + "\n",
                                  kHex.substr(0, 32) + "\n"}) {
    CAPTURE(half);
    CHECK(KeyFile(half).refusal() ==
          "is half of a hexadecimal key (allowed: 32 bytes, or 64 hexadecimal digits)");
  }
  CHECK(KeyFile(kHex.substr(0, 31) + "g").refusal().empty());
}

TEST_CASE("a key that others may read or write is refused") {
  for (const mode_t mode : {0640U, 0604U, 0620U, 0602U, 0610U, 0601U, 0644U, 0777U}) {
    CAPTURE(mode);
    CHECK(KeyFile(raw_key(), mode)
              .refusal()
              .find("others can access the key (allowed: nothing for group and others") !=
          std::string::npos);
  }
  CHECK(KeyFile(raw_key(), 0644).refusal().starts_with("has mode 0644"));
}

TEST_CASE("a key file of another owner is refused") {
  const KeyFile file(raw_key());
  if (::geteuid() != 0) return;  // only root can give files away
  REQUIRE(::chown(file.path.c_str(), 12345, 0) == 0);
  CHECK(file.refusal() == "belongs to user 12345 (allowed: this user or root)");
}

TEST_CASE("a missing file and a directory are reported") {
  const Scratch folder;
  CHECK_THROWS_WITH(read_signing_key(folder / "key"), ("signing-key " + (folder / "key").string() +
                                                       " cannot be read: No such file or directory")
                                                          .c_str());
  CHECK_THROWS_WITH(read_signing_key(folder.path()),
                    ("signing-key " + folder.path().string() + " is not a regular file").c_str());
}

}  // namespace
}  // namespace flotilla::target
