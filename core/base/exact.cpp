#include "core/base/exact.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace boxunion {
namespace {

/// The common exponent of two numbers, and both significands at that exponent.
struct Aligned {
  BigInteger a, b;
  int e;
};

Aligned align(const Dyadic& a, const Dyadic& b) {
  if (a.e < b.e) return {a.m, b.m << static_cast<unsigned>(b.e - a.e), a.e};
  return {a.m << static_cast<unsigned>(a.e - b.e), b.m, b.e};
}

/// Rounds a magnitude q * 2^e. q has 62 or 63 bits. Its lowest bit says whether anything was cut off below,
/// so this bit only decides ties.
double round_magnitude(std::uint64_t q, int e) {
  constexpr int kDigits = 53, kLeastExponent = -1074;
  const int target = std::max(e + int(std::bit_width(q)) - kDigits, kLeastExponent);
  const int drop = target - e;  // at least 9
  if (drop >= 64) return 0;     // less than half of the least subnormal
  const std::uint64_t kept = q >> drop, rest = q - (kept << drop);
  const std::uint64_t half = std::uint64_t(1) << (drop - 1);
  const bool up = rest > half || (rest == half && (kept & 1));
  return std::ldexp(static_cast<double>(kept + up), target);  // exact, or infinite
}

}  // namespace

Dyadic dyadic(double x) {
  constexpr int kDigits = 53;
  int exponent;
  const double significand = std::frexp(x, &exponent);
  return {BigInteger(static_cast<std::int64_t>(std::ldexp(significand, kDigits))), exponent - kDigits};
}

Dyadic operator+(const Dyadic& a, const Dyadic& b) {
  const Aligned x = align(a, b);
  return {x.a + x.b, x.e};
}

Dyadic operator-(const Dyadic& a, const Dyadic& b) {
  const Aligned x = align(a, b);
  return {x.a - x.b, x.e};
}

Dyadic operator*(const Dyadic& a, const Dyadic& b) {
  return {a.m * b.m, a.e + b.e};
}

double round_quotient(const Dyadic& n, const Dyadic& d) {
  if (n.m == 0) return 0;
  BigInteger numerator = abs(n.m), denominator = abs(d.m);
  // Shift one of them so that the integer quotient has 62 or 63 bits.
  const int shift = 62 - int(msb(numerator)) + int(msb(denominator));
  if (shift >= 0)
    numerator <<= static_cast<unsigned>(shift);
  else
    denominator <<= static_cast<unsigned>(-shift);
  BigInteger quotient, remainder;
  divide_qr(numerator, denominator, quotient, remainder);
  const std::uint64_t q = static_cast<std::uint64_t>(quotient) | (remainder != 0);
  const double magnitude = round_magnitude(q, n.e - d.e - shift);
  return (n.m < 0) != (d.m < 0) ? -magnitude : magnitude;
}

double round_to_double(const Dyadic& value) {
  return round_quotient(value, {1, 0});
}

PlacedSum::PlacedSum(int exponent, std::size_t max_place, std::size_t max_words)
    : exponent_(exponent), max_words_(max_words), sums_(2 * (max_place + 1) * max_words) {}

Dyadic PlacedSum::total() const {
  BigInteger total = 0;
  for (std::size_t end = sums_.size(); end > 0; end -= 2 * max_words_) {  // from the highest place down
    const UInt128* positive = sums_.data() + end - 2 * max_words_;
    const UInt128* negative = positive + max_words_;
    BigInteger sum = 0;
    for (std::size_t i = max_words_; i-- > 0;)
      sum = (sum << 64) + (BigInteger(positive[i]) - BigInteger(negative[i]));
    total = (total << kPlaceBits) + sum;
  }
  return {std::move(total), exponent_};
}

}  // namespace boxunion
