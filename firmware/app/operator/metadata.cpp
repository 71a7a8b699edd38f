// SPDX-License-Identifier: MIT
#include "app/operator/metadata.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <initializer_list>

#include "app/parameters.hpp"
#include "link/mavlink/crc32.hpp"

namespace flotilla::app {
namespace {

/// Whether the text is valid inside JSON quotation marks as it is.
consteval bool needs_no_escape(std::string_view text) {
  return std::ranges::none_of(text, [](char c) {
    return c == '"' || c == '\\' || static_cast<unsigned char>(c) < ' ' || c == '\x7F';
  });
}

/// Removes leading digits; returns whether there were any.
consteval bool take_digits(std::string_view& text) {
  const std::size_t n = std::min(text.find_first_not_of("0123456789"), text.size());
  text.remove_prefix(n);
  return n > 0;
}

/// JSON is stricter than C++: no "1.", ".5", "010" or "1.0F".
consteval bool is_json_number(std::string_view text) {
  if (text.starts_with('-')) text.remove_prefix(1);
  if (text.size() > 1 && text[0] == '0' && text[1] != '.') return false;
  if (!take_digits(text)) return false;
  if (text.empty()) return true;
  text.remove_prefix(text.starts_with('.') ? 1 : 0);
  return take_digits(text) && text.empty();
}

#define FLOTILLA_PARAMETER(group, name, unit, value, least, greatest, kind, change, sentence)  \
  static_assert(needs_no_escape(group) && needs_no_escape(unit) && needs_no_escape(sentence),  \
                "parameters.def, " #name ": a text needs escaping in JSON");                   \
  static_assert(is_json_number(#value) && is_json_number(#least) && is_json_number(#greatest), \
                "parameters.def, " #name ": a number is not written as in JSON");
#include "app/parameters.def"
#undef FLOTILLA_PARAMETER

// JSON fragments for a parameter's Kind and Change
#define FLOTILLA_VALUE(number, text) "{\"value\":" #number ",\"description\":\"" text "\"}"
#define FLOTILLA_KIND_Real "\"decimalPlaces\":4"
#define FLOTILLA_KIND_Whole "\"decimalPlaces\":0,\"increment\":1"
#define FLOTILLA_KIND_Sign "\"decimalPlaces\":0,\"values\":[" FLOTILLA_SIGNS "]"
#define FLOTILLA_KIND_Identity "\"decimalPlaces\":0,\"values\":[" FLOTILLA_IDENTITIES "]"
#define FLOTILLA_IDENTITIES FLOTILLA_VALUE(0, "vehicle") "," FLOTILLA_VALUE(1, "companion")
#define FLOTILLA_KIND_Frame "\"decimalPlaces\":0,\"values\":[" FLOTILLA_FRAMES "]"
#define FLOTILLA_FRAMES FLOTILLA_VALUE(0, "north-east") "," FLOTILLA_VALUE(1, "ahead-starboard")
#define FLOTILLA_KIND_Switch "\"decimalPlaces\":0,\"values\":[" FLOTILLA_SWITCH "]"
#define FLOTILLA_SWITCH FLOTILLA_VALUE(0, "off") "," FLOTILLA_VALUE(1, "on")
#define FLOTILLA_KIND_Action "\"decimalPlaces\":0,\"values\":[" FLOTILLA_ACTIONS "]"
#define FLOTILLA_ACTIONS    \
  FLOTILLA_VALUE(0, "HOLD") \
  "," FLOTILLA_VALUE(1, "COAST, then HOLD") "," FLOTILLA_VALUE(2, "MANUAL with fresh sticks")
#define FLOTILLA_SIGNS FLOTILLA_VALUE(-1, "reversed") "," FLOTILLA_VALUE(1, "normal")
#define FLOTILLA_CHANGE_Anytime "\"rebootRequired\":false"
#define FLOTILLA_CHANGE_Disarmed "\"rebootRequired\":false"
#define FLOTILLA_CHANGE_Restart "\"rebootRequired\":true"

#define FLOTILLA_PARAMETER(group, name, unit, value, least, greatest, kind, change, sentence)    \
  ",{\"name\":\"" #name "\",\"type\":\"Float\",\"shortDesc\":\"" sentence "\",\"units\":\"" unit \
  "\",\"default\":" #value ",\"min\":" #least ",\"max\":" #greatest "," FLOTILLA_KIND_##kind     \
      "," FLOTILLA_CHANGE_##change ",\"group\":\"" group "\",\"category\":\"Standard\"}"
constexpr std::string_view kEntries =
#include "app/parameters.def"
    ;
#undef FLOTILLA_PARAMETER

/// Concatenates the parts; N is their total length.
template <std::size_t N>
consteval std::array<char, N> joined(std::initializer_list<std::string_view> parts) {
  std::array<char, N> text{};
  auto end = text.begin();
  for (const std::string_view part : parts) end = std::copy(part.begin(), part.end(), end);
  return text;
}

template <std::size_t N>
consteval std::string_view view(const std::array<char, N>& text) {
  return {text.data(), N};
}

constexpr std::string_view kHead = R"({"version":1,"parameters":[)", kTail = "]}";
constexpr auto kParameters =
    joined<kHead.size() + kEntries.size() - 1 + kTail.size()>({kHead, kEntries.substr(1), kTail});

constexpr std::size_t kCrcDigits = 10;

/// A CRC as a JSON number: no leading zeros, so padded with blanks.
consteval std::array<char, kCrcDigits> digits_of(std::uint32_t number) {
  std::array<char, kCrcDigits> text{};
  for (std::size_t i = kCrcDigits; i > 0; --i) {
    const bool blank = number == 0 && i < kCrcDigits;
    text[i - 1] = blank ? ' ' : static_cast<char>('0' + number % 10);
    number /= 10;
  }
  return text;
}

constexpr auto kParametersCrc = digits_of(link::crc32(link::kMavlinkCrc32Start, view(kParameters)));
constexpr std::string_view kGeneralHead =
    R"({"version":1,"metadataTypes":[{"type":1,"uri":"mftp:///parameters.json","fileCrc":)";
constexpr std::string_view kGeneralTail = "}]}";
constexpr auto kGeneral = joined<kGeneralHead.size() + kCrcDigits + kGeneralTail.size()>(
    {kGeneralHead, view(kParametersCrc), kGeneralTail});

constexpr std::array kFiles{link::FtpFile{"general.json", view(kGeneral)},
                            link::FtpFile{"parameters.json", view(kParameters)}};

}  // namespace

std::uint32_t general_crc() {
  constexpr std::uint32_t kCrc = link::crc32(link::kMavlinkCrc32Start, view(kGeneral));
  return kCrc;
}

std::span<const link::FtpFile> metadata_files() { return kFiles; }

}  // namespace flotilla::app
