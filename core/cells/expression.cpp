#include "core/cells/expression.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <limits>
#include <optional>
#include <unordered_map>
#include <utility>

#include "boxunion/error.hpp"

namespace boxunion {
namespace {

using Kind = Step::Kind;

[[noreturn]] void fail(std::size_t position, const std::string& message) {
  throw Error(ErrorKind::usage, fmt::format("expression, column {}: {}", position + 1, message));
}

/// A word or symbol of an expression.
struct Token {
  enum class Kind { name, operation, open, close, end };
  Kind kind = Kind::end;
  std::string_view text;
  std::size_t position = 0;
  Step::Kind operation{};  // of an operation

  std::string quoted() const { return kind == Kind::end ? "the end" : fmt::format("'{}'", text); }
};

std::optional<Kind> operation_of(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, Kind>, 9> kWords{{{"and", Kind::intersection},
                                                                     {"&", Kind::intersection},
                                                                     {"or", Kind::union_of_both},
                                                                     {"|", Kind::union_of_both},
                                                                     {"xor", Kind::symmetric_difference},
                                                                     {"^", Kind::symmetric_difference},
                                                                     {"not", Kind::difference},
                                                                     {"minus", Kind::difference},
                                                                     {"-", Kind::difference}}};
  const auto lower = [](char c) { return char(std::tolower(static_cast<unsigned char>(c))); };
  for (const auto& [word, operation] : kWords)
    if (std::ranges::equal(text, word, {}, lower)) return operation;
  return std::nullopt;
}

int precedence(Kind operation) {
  return operation == Kind::union_of_both ? 0 : operation == Kind::symmetric_difference ? 1 : 2;
}

bool is_name_character(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_';
}

std::vector<Token> tokens_of(std::string_view text) {
  std::vector<Token> tokens;
  for (std::size_t at = 0; at < text.size();) {
    if (std::isspace(static_cast<unsigned char>(text[at]))) {
      ++at;
      continue;
    }
    std::size_t end = at + 1;
    if (is_name_character(text[at]))
      while (end < text.size() && is_name_character(text[end])) ++end;
    Token token{Token::Kind::name, text.substr(at, end - at), at, {}};
    if (token.text == "(") {
      token.kind = Token::Kind::open;
    } else if (token.text == ")") {
      token.kind = Token::Kind::close;
    } else if (const auto operation = operation_of(token.text)) {
      token.kind = Token::Kind::operation;
      token.operation = *operation;
    } else if (!is_name_character(text[at])) {
      fail(at, fmt::format("unexpected '{}'", token.text));
    } else if (std::isdigit(static_cast<unsigned char>(text[at]))) {
      fail(at, fmt::format("'{}' is not a name: a name begins with a letter or _", token.text));
    }
    tokens.push_back(token);
    at = end;
  }
  tokens.push_back({Token::Kind::end, {}, text.size(), {}});
  return tokens;
}

/// Dijkstra's shunting yard. It makes a tree whose nodes know how many places on the stack their steps need.
class Parser {
 public:
  void parse(std::string_view text) {
    bool operand_expected = true;
    for (const Token& token : tokens_of(text)) {
      if (operand_expected)
        operand_expected = take_operand(token);
      else
        operand_expected = take_operation(token);
    }
  }

  /// The steps of the tree. Of two results, the one that needs more places comes first.
  std::vector<Step> steps() const {
    std::vector<Step> steps;  // last to first
    for (std::vector<std::uint32_t> open = results_; !open.empty();) {
      const Node& node = nodes_[open.back()];
      open.pop_back();
      Step& step = steps.emplace_back(node.step);
      if (step.kind == Kind::operand) continue;
      const bool is_reversed = nodes_[node.b].depth > nodes_[node.a].depth;
      if (is_reversed && step.kind == Kind::difference) step.kind = Kind::reversed_difference;
      open.push_back(is_reversed ? node.b : node.a);
      open.push_back(is_reversed ? node.a : node.b);
    }
    std::ranges::reverse(steps);
    return steps;
  }

  std::vector<std::string> names;
  std::vector<std::size_t> columns;

 private:
  /// An operand, or an operation on two nodes.
  struct Node {
    Step step;
    std::uint32_t depth = 1, a = 0, b = 0;
  };

  void push(const Node& node) {
    if (nodes_.size() == std::numeric_limits<std::uint32_t>::max())
      throw Error(ErrorKind::resources, "the expression has 2^32 operands and operations or more");
    results_.push_back(std::uint32_t(nodes_.size()));
    nodes_.push_back(node);
  }
  std::uint32_t pop() {
    const std::uint32_t node = results_.back();
    results_.pop_back();
    return node;
  }

  /// Takes a name or an opening parenthesis. Returns true if an operand must still follow.
  bool take_operand(const Token& token) {
    switch (token.kind) {
      case Token::Kind::name:
        push({.step = {Kind::operand, operand(token)}});
        return false;
      case Token::Kind::open:
        waiting_.push_back(token);
        return true;
      case Token::Kind::operation:
        if (token.operation == Kind::difference) {
          Token* const before = waiting_.empty() ? nullptr : &waiting_.back();
          if (before && before->kind == Token::Kind::operation && before->operation == Kind::intersection) {
            before->operation = Kind::difference;  // "and not"
            return true;
          }
          fail(token.position,
               fmt::format("{} needs an operand on its left, such as \"A not B\": a complement has no bounds",
                           token.quoted()));
        }
        [[fallthrough]];
      default:
        fail(token.position, fmt::format("expected a name or '(', found {}", token.quoted()));
    }
  }

  /// Takes what follows an operand. Returns true if another operand must follow.
  bool take_operation(const Token& token) {
    switch (token.kind) {
      case Token::Kind::operation:
        reduce(precedence(token.operation));
        waiting_.push_back(token);
        return true;
      case Token::Kind::close:
        reduce(0);
        if (waiting_.empty()) fail(token.position, "')' without '('");
        waiting_.pop_back();
        return false;
      case Token::Kind::end:
        reduce(0);
        if (!waiting_.empty()) fail(waiting_.back().position, "'(' without ')'");
        return false;
      default:
        fail(token.position, fmt::format("expected an operation or ')', found {}", token.quoted()));
    }
  }

  /// Applies the waiting operations, back to a parenthesis or to an operation that binds less.
  void reduce(int least) {
    while (!waiting_.empty() && waiting_.back().kind == Token::Kind::operation &&
           precedence(waiting_.back().operation) >= least) {
      const Token token = waiting_.back();
      waiting_.pop_back();
      const std::uint32_t b = pop(), a = pop(), most = std::max(nodes_[a].depth, nodes_[b].depth);
      const std::uint32_t depth = nodes_[a].depth == nodes_[b].depth ? most + 1 : most;
      if (depth > Expression::kMostDepth)
        fail(token.position,
             fmt::format("this needs more than {} intermediate results", Expression::kMostDepth));
      push({{token.operation, 0}, depth, a, b});
    }
  }

  std::uint32_t operand(const Token& name) {
    const auto [at, is_new] = indices_.try_emplace(name.text, std::uint32_t(names.size()));
    if (is_new) {
      names.emplace_back(name.text);
      columns.push_back(name.position + 1);
    }
    return at->second;
  }

  std::vector<Token> waiting_;  // operations and opening parentheses
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> results_;                           // nodes that wait for an operation
  std::unordered_map<std::string_view, std::uint32_t> indices_;  // of names
};

}  // namespace

Expression Expression::parse(std::string_view text) {
  Parser parser;
  parser.parse(text);
  Expression expression;
  expression.names_ = std::move(parser.names);
  expression.columns_ = std::move(parser.columns);
  expression.steps_ = parser.steps();
  return expression;
}

bool Expression::is_name(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, is_name_character) &&
         !std::isdigit(static_cast<unsigned char>(text[0])) && !operation_of(text);
}

Expression Expression::one_operand() {
  return parse("boxes");
}

bool Expression::is_union() const {
  return boxunion::is_union(steps_);
}

bool is_union(std::span<const Step> steps) {
  return std::ranges::all_of(steps,
                             [](Step s) { return s.kind == Kind::operand || s.kind == Kind::union_of_both; });
}

Filling simplify(std::span<const Step> steps, std::span<const Presence> presence, std::vector<Step>& result) {
  // for every result on the stack: the begin of its steps, and its value if it is constant
  struct Value {
    std::size_t begin;
    Filling filling;
  };
  std::array<Value, Expression::kMostDepth> stack;
  std::size_t top = 0;
  result.clear();
  const auto complement = [&](Value& value) {
    if (value.filling != Filling::varies)
      value.filling = value.filling == Filling::nothing ? Filling::everything : Filling::nothing;
    else if (result.back().kind == Kind::complement)
      result.pop_back();
    else
      result.push_back({Kind::complement, 0});
  };
  for (const Step step : steps) {
    if (step.kind == Kind::operand) {
      const Presence p = presence[step.operand];
      stack[top++] = {result.size(), p == Presence::absent ? Filling::nothing
                                     : p == Presence::all  ? Filling::everything
                                                           : Filling::varies};
      if (p == Presence::partial) result.push_back(step);
      continue;
    }
    if (step.kind == Kind::complement) {
      complement(stack[top - 1]);
      continue;
    }
    const Value b = stack[--top];
    Value& a = stack[top - 1];
    if (a.filling == Filling::varies && b.filling == Filling::varies) {
      result.push_back(step);
      continue;
    }
    const bool b_is_constant = b.filling != Filling::varies;
    const bool constant = (b_is_constant ? b : a).filling == Filling::everything;
    const Filling other = b_is_constant ? a.filling : b.filling;
    // the result is the other operand, its complement, or a constant
    const auto settle = [&](bool value) {
      result.resize(a.begin);
      a.filling = value ? Filling::everything : Filling::nothing;
    };
    a.filling = other;
    switch (step.kind) {
      case Kind::intersection:
        if (!constant) settle(false);
        break;
      case Kind::union_of_both:
        if (constant) settle(true);
        break;
      case Kind::symmetric_difference:
        if (constant) complement(a);
        break;
      default:  // a difference: either the constant or the other operand is subtracted
        if ((step.kind == Kind::difference) == b_is_constant) {
          if (constant) settle(false);
        } else if (constant) {
          complement(a);
        } else {
          settle(false);
        }
    }
  }
  return stack[0].filling;
}

}  // namespace boxunion
