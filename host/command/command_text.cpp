#include "host/command/command_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace boxunion::command {
namespace {

/// The first character of a text.
struct Character {
  enum class Kind { plain, control, invalid } kind;
  std::size_t bytes;
};

/// The first character of a text that is not empty, by table 3-7 of the Unicode standard. A byte that begins
/// no well-formed sequence stands alone.
Character first_character(std::string_view text) {
  using enum Character::Kind;
  const auto byte = [&](std::size_t i) { return i < text.size() ? std::uint8_t(text[i]) : 0u; };
  const auto is_between = [&](std::size_t i, unsigned low, unsigned high) {
    return low <= byte(i) && byte(i) <= high;
  };
  const auto is_tail = [&](std::size_t i) { return is_between(i, 0x80, 0xbf); };
  const unsigned first = byte(0);
  if (first < 0x80) return {first < 0x20 || first == 0x7f ? control : plain, 1};
  if (is_between(0, 0xc2, 0xdf) && is_tail(1)) return {first == 0xc2 && byte(1) < 0xa0 ? control : plain, 2};
  if (is_between(0, 0xe0, 0xef) && is_tail(2) &&
      is_between(1, first == 0xe0 ? 0xa0 : 0x80, first == 0xed ? 0x9f : 0xbf))
    return {plain, 3};
  if (is_between(0, 0xf0, 0xf4) && is_tail(2) && is_tail(3) &&
      is_between(1, first == 0xf0 ? 0x90 : 0x80, first == 0xf4 ? 0x8f : 0xbf))
    return {plain, 4};
  return {invalid, 1};
}

/// Joins the results of `show` for each character.
template <class Show>
std::string map_characters(std::string_view text, Show&& show) {
  std::string shown;
  shown.reserve(text.size());
  while (!text.empty()) {
    const auto [kind, bytes] = first_character(text);
    shown += show(kind, text.substr(0, bytes));
    text.remove_prefix(bytes);
  }
  return shown;
}

std::string escaped(std::string_view character) {
  if (character == "\n") return "\\n";
  if (character == "\r") return "\\r";
  if (character == "\t") return "\\t";
  std::string text;
  for (const char byte : character) text += fmt::format("\\x{:02x}", std::uint8_t(byte));
  return text;
}

}  // namespace

std::string printable(std::string_view text) {
  return map_characters(text, [](Character::Kind kind, std::string_view character) {
    return kind == Character::Kind::plain ? std::string(character) : escaped(character);
  });
}

std::string printable_lines(std::string_view text) {
  std::string shown;
  for (std::size_t begin = 0, end; begin < text.size(); begin = end + 1) {
    end = std::min(text.find('\n', begin), text.size());
    shown += printable(text.substr(begin, end - begin));
    if (end < text.size()) shown += '\n';
  }
  return shown;
}

std::string json_string(std::string_view text) {
  const std::string characters = map_characters(text, [](Character::Kind kind, std::string_view character) {
    if (kind == Character::Kind::invalid) return std::string("\\ufffd");
    if (kind == Character::Kind::control)  // the number of a character from U+0080 to U+009F is its last byte
      return fmt::format("\\u{:04x}", std::uint8_t(character.back()));
    return fmt::format("{}{}", character == "\"" || character == "\\" ? "\\" : "", character);
  });
  return fmt::format("\"{}\"", characters);
}

}  // namespace boxunion::command
