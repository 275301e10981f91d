#include "core/base/exact.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/support/reference.hpp"

namespace boxunion {
namespace {

mpq_class rational(const Dyadic& value) {
  mpq_class result(mpz_class(value.m.str()));
  if (value.e < 0)
    mpq_div_2exp(result.get_mpq_t(), result.get_mpq_t(), static_cast<mp_bitcnt_t>(-value.e));
  else
    mpq_mul_2exp(result.get_mpq_t(), result.get_mpq_t(), static_cast<mp_bitcnt_t>(value.e));
  return result;
}

/// Integers of `words` 64-bit words, often with leading zeros, with exponents in a range.
rc::Gen<Dyadic> dyadic(std::size_t words, int exponents) {
  const auto word =
      rc::gen::oneOf(rc::gen::arbitrary<std::uint64_t>(), rc::gen::element<std::uint64_t>(0, 0, 0, 1, ~0ull));
  const auto parts = rc::gen::tuple(rc::gen::container<std::vector<std::uint64_t>>(words, word),
                                    rc::gen::inRange(-exponents, exponents), rc::gen::arbitrary<bool>());
  return rc::gen::resize(rc::kNominalSize, rc::gen::map(parts, [](const auto& chosen) {
                           Dyadic value{0, std::get<1>(chosen)};
                           for (const std::uint64_t w : std::get<0>(chosen)) value.m = (value.m << 64) + w;
                           if (std::get<2>(chosen)) value.m = -value.m;
                           return value;
                         }));
}

RC_GTEST_PROP(Exact, DyadicArithmeticIsThatOfRationals, ()) {
  const Dyadic a = *dyadic(4, 100), b = *dyadic(4, 100);
  RC_ASSERT(rational(a + b) == rational(a) + rational(b));
  RC_ASSERT(rational(a - b) == rational(a) - rational(b));
  RC_ASSERT(rational(a * b) == rational(a) * rational(b));
}

RC_GTEST_PROP(Exact, QuotientsAreRoundedOnce, ()) {
  const Dyadic n = *dyadic(5, 1300), d = *dyadic(4, 100);
  RC_PRE(d.m != 0);
  RC_ASSERT(round_quotient(n, d) == round_to_nearest(rational(n) / rational(d)));
  RC_ASSERT(round_to_double(n) == round_to_nearest(rational(n)));
}

RC_GTEST_PROP(Exact, TiesGoToEvenAndTheLeastExcessDecides, ()) {
  // A double plus half a unit of its last place, and a little more or less.
  const auto digits = *rc::gen::inRange<std::int64_t>(1ll << 52, 1ll << 53);
  const int exponent = *rc::gen::inRange(-1200, 1000), hair = *rc::gen::inRange(-1, 2);
  const Dyadic value = Dyadic{BigInteger(2 * digits + 1), exponent} + Dyadic{hair, exponent - 300};
  RC_ASSERT(round_to_double(value) == round_to_nearest(rational(value)));
}

TEST(Exact, RoundingReachesSubnormalsAndInfinity) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(round_to_double({1, -1074}), 5e-324);
  EXPECT_EQ(round_to_double({1, -1075}), 0);  // tie to even
  EXPECT_EQ(round_to_double({3, -1076}), 5e-324);
  EXPECT_EQ(round_to_double({-3, -1075}), -1e-323);  // tie to even
  EXPECT_EQ(round_to_double({1, -20000}), 0);
  EXPECT_EQ(round_to_double({1, 20000}), kInfinity);
  EXPECT_EQ(round_to_double({-1, 1024}), -kInfinity);
  EXPECT_EQ(round_to_double(Dyadic{1, 1024} - Dyadic{1, 970}), kInfinity);  // tie above the greatest double
  EXPECT_EQ(round_to_double(Dyadic{1, 1024} - Dyadic{3, 969}), std::numeric_limits<double>::max());
  EXPECT_EQ(round_quotient({1, 0}, {3, 0}), 1 / 3.);
}

template <bool kNarrow>
void check_product_sum(unsigned p_bits, unsigned f_bits) {
  std::mt19937_64 random(3);
  ProductSum<kNarrow> sum;
  BigInteger expected = 0;
  for (int i = 0; i < 20000; ++i) {
    Int128 p = static_cast<Int128>((UInt128(random()) << 64 | random()) >> (128 - p_bits));
    if (i % 3 == 0) p = -p;
    const std::uint64_t f = random() >> (64 - f_bits);
    sum.add(p, f);
    expected += BigInteger(p) * f;
  }
  EXPECT_EQ(sum.total(), expected);
}

TEST(Exact, ProductSumsAreExact) {
  check_product_sum<true>(62, 42);
  check_product_sum<true>(3, 3);
  check_product_sum<false>(98, 64);
  check_product_sum<false>(64, 64);
  check_product_sum<false>(5, 64);
}

template <std::size_t N>
void check_placed_sum(int exponent, unsigned max_place) {
  std::mt19937_64 random(5);
  PlacedSum sum(exponent, max_place, 5);
  Dyadic expected;
  for (int i = 0; i < 2000; ++i) {
    Words<N> words;
    BigInteger m = 0;
    for (std::size_t word = N; word-- > 0;) m = (m << 64) + (words[word] = i % 5 ? random() : ~0ull);
    const unsigned place = i == 0 ? 0 : i == 1 ? max_place : unsigned(random() % (max_place + 1));
    const bool negative = random() % 2;
    sum.add(words, negative, place);
    expected = expected + Dyadic{negative ? -m : m, exponent + PlacedSum::kPlaceBits * int(place)};
  }
  EXPECT_EQ((sum.total() - expected).m, 0);
}

TEST(Exact, PlacedSumsAreExact) {
  check_placed_sum<1>(0, 0);
  check_placed_sum<2>(-1074, 255);
  check_placed_sum<3>(-3, 5);
  check_placed_sum<5>(-5370, 1278);
}

TEST(Exact, WordsTimesWordKeepsEveryBit) {
  const Words<3> product = Words<2>{~0ull, ~0ull} * ~0ull;
  EXPECT_EQ(product, (Words<3>{1, ~0ull, ~0ull - 1}));
}

}  // namespace
}  // namespace boxunion
