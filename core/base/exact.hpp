#pragma once

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace boxunion {

// Exact sums, and the one rounding at the end. Only .cpp files include this header, because it needs Boost
// and users of boxunion do not.

using Int128 = __int128;
using UInt128 = unsigned __int128;
using BigInteger = boost::multiprecision::cpp_int;

/// An exact sum of products Int128 * uint64 on a lattice; a product takes about a nanosecond.
///
/// The sum is low + high * 2^64, two 128-bit integers that need no carry between them. It has room for 2^23
/// products p * f with |p| < 2^100. For narrow products (p and f fit int64, p * f stays below 2^104), `low`
/// alone is enough.
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

/// The number m * 2^e.
struct Dyadic {
  BigInteger m = 0;
  int e = 0;
};
/// A finite double as such a number.
Dyadic dyadic(double x);
Dyadic operator+(const Dyadic& a, const Dyadic& b);
Dyadic operator-(const Dyadic& a, const Dyadic& b);
Dyadic operator*(const Dyadic& a, const Dyadic& b);
inline Dyadic operator*(int factor, const Dyadic& a) {
  return {factor * a.m, a.e};
}

/// n / d rounded once to the nearest double, ties to even: subnormal when small, infinite when beyond the
/// range of double. d must not be zero.
double round_quotient(const Dyadic& n, const Dyadic& d);
/// The same for one number.
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

/// sum += a * b modulo 2^64N; fast if the compiler knows all sizes.
template <std::size_t N, std::size_t A, std::size_t B>
constexpr void add_product(Words<N>& sum, const Words<A>& a, const Words<B>& b) {
  UInt128 column = 0;
  for (std::size_t k = 0; k < N; ++k) {
    std::uint64_t carry = 0;
    column += sum[k];  // no carry needed: the last columns leave at most 2^65
    for (std::size_t i = k < B ? 0 : k - B + 1; i < A && i <= k; ++i) {
      const UInt128 product = UInt128(a[i]) * b[k - i];
      if constexpr (A == 1 || B == 1)
        column += product;  // and at most 2^64 - 1 here
      else
        carry += __builtin_add_overflow(column, product, &column);
    }
    sum[k] = static_cast<std::uint64_t>(column);
    column = column >> 64 | UInt128(carry) << 64;
  }
}

/// Adds modulo 2^64N.
template <std::size_t N>
constexpr Words<N>& operator+=(Words<N>& a, const Words<N>& b) {
  UInt128 carry = 0;
  for (std::size_t i = 0; i < N; ++i) {
    carry += UInt128(a[i]) + b[i];
    a[i] = static_cast<std::uint64_t>(carry);
    carry >>= 64;
  }
  return a;
}

/// Subtracts modulo 2^64N.
template <std::size_t N>
constexpr Words<N> operator-(const Words<N>& a, const Words<N>& b) {
  Words<N> difference{};
  std::uint64_t borrow = 0;
  for (std::size_t i = 0; i < N; ++i) {
    const UInt128 word = UInt128(a[i]) - b[i] - borrow;
    difference[i] = static_cast<std::uint64_t>(word);
    borrow = static_cast<std::uint64_t>(word >> 64) & 1;
  }
  return difference;
}

/// An exact sum of numbers +-words * 2^(exponent + 8 * place).
///
/// The numbers of each place and sign have their own sum, with one 128-bit integer for each word. An addition
/// shifts nothing, negates nothing and propagates no carry, and there is room for 2^64 additions. (After
/// Neal, "Fast exact summation using small and large superaccumulators", 2015, whose large accumulator has a
/// sum for each exponent.)
class PlacedSum {
 public:
  static constexpr int kPlaceBits = 8;

  /// For addends of at most `max_words` words at places 0 .. max_place.
  PlacedSum(int exponent, std::size_t max_place, std::size_t max_words);

  template <std::size_t N>
  void add(const Words<N>& words, bool negative, std::size_t place) {
    UInt128* sum = sums_.data() + (2 * place + negative) * max_words_;
    for (std::size_t i = 0; i < N; ++i) sum[i] += words[i];
  }
  Dyadic total() const;

 private:
  int exponent_;
  std::size_t max_words_;
  std::vector<UInt128> sums_;  // by place, sign and word
};

}  // namespace boxunion
