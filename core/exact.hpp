#pragma once

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace boxunion {

// Exact sums and their one rounding. Only .cpp files include this header (it needs Boost, boxunion's users do
// not).

using Int128 = __int128;
using UInt128 = unsigned __int128;
using BigInteger = boost::multiprecision::cpp_int;

/// An exact sum of products Int128 * uint64 on a lattice; about a nanosecond a product.
///
/// The sum is low + high * 2^64, two 128-bit integers that need no carry between them. It has room for 2^23
/// products of which |p| < 2^100. Of narrow products (p and f fit int64, p * f stays below 2^104) `low` alone
/// is enough.
template <bool kNarrow>
class ProductSum {
 public:
  void add(Int128 p, std::uint64_t f) {
    if constexpr (kNarrow) {
      low_ += Int128(static_cast<std::int64_t>(p)) * static_cast<std::int64_t>(f);
    } else {
      const UInt128 low = UInt128(static_cast<std::uint64_t>(p)) * f;
      low_ += static_cast<std::uint64_t>(low);
      high_ += static_cast<Int128>(low >> 64) + Int128(static_cast<std::int64_t>(p >> 64)) * f;
    }
  }
  BigInteger total() const { return BigInteger(low_) + (BigInteger(high_) << 64); }

 private:
  Int128 low_ = 0, high_ = 0;
};

/// m * 2^e, exactly.
struct Dyadic {
  BigInteger m = 0;
  int e = 0;
};
Dyadic operator+(const Dyadic& a, const Dyadic& b);
Dyadic operator-(const Dyadic& a, const Dyadic& b);
Dyadic operator*(const Dyadic& a, const Dyadic& b);
inline Dyadic operator*(int factor, const Dyadic& a) {
  return {factor * a.m, a.e};
}

/// n / d rounded once to the nearest double, ties to even: subnormal when small, infinite when beyond the
/// range of double. d must not be zero.
double round_quotient(const Dyadic& n, const Dyadic& d);
/// The same of one number.
double round_to_double(const Dyadic& value);

/// An unsigned integer of N words, the lowest first.
template <std::size_t N>
using Words = std::array<std::uint64_t, N>;

/// a * b, with room for every bit.
template <std::size_t N>
constexpr Words<N + 1> operator*(const Words<N>& a, std::uint64_t b) {
  Words<N + 1> product{};
  UInt128 carry = 0;
  for (std::size_t i = 0; i < N; ++i) {
    carry += UInt128(a[i]) * b;
    product[i] = static_cast<std::uint64_t>(carry);
    carry >>= 64;
  }
  product[N] = static_cast<std::uint64_t>(carry);
  return product;
}

/// An exact sum of numbers +-words * 2^exponent whose exponents lie in a range known beforehand.
///
/// A fixed-point number as wide as that takes, in digits of 32 bits that are kept in signed 64-bit integers:
/// a sum touches only the digits under the addend and propagates no carry until 2^30 addends have come (Neal,
/// "Fast exact summation using small and large superaccumulators", 2015).
class FixedPointSum {
 public:
  /// For addends of at most `max_words` words with low_exponent <= exponent <= high_exponent.
  FixedPointSum(int low_exponent, int high_exponent, std::size_t max_words);

  template <std::size_t N>
  void add(const Words<N>& words, bool negative, int exponent) {
    if (++addends_ == kMaxAddends) normalize();
    const auto offset = static_cast<unsigned>(exponent - low_exponent_);
    const unsigned shift = offset % 32;
    const std::int64_t sign = -std::int64_t(negative);  // x ^ sign - sign is x or -x
    std::int64_t* digit = digits_.data() + offset / 32;
    std::uint64_t carry = 0;
    for (std::size_t i = 0; i < N; ++i) {
      const std::uint64_t word = words[i] << shift | carry;
      carry = words[i] >> 1 >> (63 - shift);
      *digit++ += (static_cast<std::int64_t>(word & 0xffffffffu) ^ sign) - sign;
      *digit++ += (static_cast<std::int64_t>(word >> 32) ^ sign) - sign;
    }
    *digit += (static_cast<std::int64_t>(carry) ^ sign) - sign;
  }
  /// Propagates the carries, which `add` does by itself in time.
  void normalize();
  Dyadic total() const;

 private:
  static constexpr std::uint32_t kMaxAddends = 1u << 30;

  int low_exponent_;
  std::uint32_t addends_ = 0;
  std::vector<std::int64_t> digits_;
};

}  // namespace boxunion
