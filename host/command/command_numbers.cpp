#include "host/command/command_numbers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

namespace boxunion::command {
namespace {

constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();

/// Removes the number at the start of a text and returns it; nothing if there is none.
template <class T>
std::optional<T> take_number(std::string_view& text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  T value;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc()) return std::nullopt;
  text.remove_prefix(std::size_t(end - text.data()));
  return value;
}

/// A product as a whole number, rounded down if `rounds`. Nothing if it is not a whole number of 64 bits.
std::optional<std::uint64_t> whole(double value, std::uint64_t factor, bool rounds) {
  const double product = std::floor(value * double(factor));
  if (!(product >= 0 && product < 0x1p64) || (!rounds && product != value)) return std::nullopt;
  return std::uint64_t(product);
}

/// Digits alone are exact. A number with a point or an exponent is parsed as a double.
std::optional<std::uint64_t> parse_whole(std::string_view text) {
  std::string_view rest = text;
  if (const auto digits = take_number<std::uint64_t>(rest); digits && rest.empty()) return digits;
  rest = text;
  const auto value = take_number<double>(rest);
  return value && rest.empty() ? whole(*value, 1, false) : std::nullopt;
}

/// The factor of a unit: "", "B", "K", "KB" or "KiB" in upper or lower case. Nothing for anything else.
std::optional<std::uint64_t> parse_unit(std::string_view text) {
  constexpr std::string_view kPrefixes = "kmgt";
  std::string unit(text.substr(std::min(text.find_first_not_of(' '), text.size())));
  std::ranges::transform(unit, unit.begin(), [](char c) { return 'A' <= c && c <= 'Z' ? char(c + 32) : c; });
  if (unit.empty() || unit == "b") return 1;
  const std::size_t prefix = kPrefixes.find(unit.front());
  const std::string_view end = std::string_view(unit).substr(1);
  if (prefix == kPrefixes.npos || (!end.empty() && end != "b" && end != "i" && end != "ib"))
    return std::nullopt;
  return std::uint64_t{1024} << (10 * prefix);
}

std::optional<std::uint64_t> parse_bytes(std::string_view text) {
  if (const auto digits = parse_whole(text)) return digits;
  const auto value = take_number<double>(text);
  const auto factor = parse_unit(text);
  return value && factor ? whole(*value, *factor, true) : std::nullopt;
}

/// A validator for texts that `parse` turns into a number from `least` to `most`.
template <class Parse>
CLI::Validator number_in(std::uint64_t least, std::uint64_t most, const std::string& expected, Parse parse) {
  return CLI::Validator(
      [=](std::string& text) {
        const std::optional<std::uint64_t> value = parse(text);
        if (!value || *value < least || *value > most)
          return fmt::format("found \"{}\", expected {}", text, expected);
        text = fmt::to_string(*value);
        return std::string();
      },
      "");
}

}  // namespace

CLI::Validator whole_number(std::uint64_t least, std::uint64_t most) {
  const std::string limit = most == kMost ? "2^64 - 1" : fmt::to_string(most);
  const std::string range = fmt::format("{} to {}", least, limit);
  return number_in(least, most, "a whole number from " + range, parse_whole).description(range);
}

CLI::Validator byte_count() {
  return number_in(1, kMost, "a size such as 512M, 1.5G or 2GiB", parse_bytes);
}

CLI::Validator finite_number() {
  return CLI::Validator(
      [](std::string& text) {
        std::string_view rest = text;
        const auto value = take_number<double>(rest);
        if (!value || !rest.empty() || !std::isfinite(*value))
          return fmt::format("found \"{}\", expected a finite number", text);
        text = fmt::to_string(*value);
        return std::string();
      },
      "");
}

}  // namespace boxunion::command
