// From a file of arbitrary coordinates to mass properties, compared with rational arithmetic over voxels,
// rounded once.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <bit>
#include <cmath>

#include "boxunion/union.hpp"
#include "host/files/files.hpp"
#include "tests/support/generators.hpp"
#include "tests/support/reference.hpp"
#include "tests/support/temporary.hpp"

namespace boxunion {
namespace {

void check_from_file_to_numbers(const std::vector<Box>& boxes) {
  const MassProperties expected = brute_force_mass(boxes);
  const TemporaryFolder folder;
  for (const char* name : {"boxes.csv", "boxes.npy"}) {
    write_boxes(boxes, open_output(folder.file(name)));
    RC_ASSERT(measure(read_boxes(folder.file(name)), {.device = "native"}) == expected);
  }
}

RC_GTEST_PROP(EndToEnd, DecimalsAreRoundedOnce, ()) {
  check_from_file_to_numbers(*boxes_from(decimal()));
}
RC_GTEST_PROP(EndToEnd, NastyCoordinatesAreRoundedOnce, ()) {
  check_from_file_to_numbers(*boxes_from(nasty_coordinate()));
}
RC_GTEST_PROP(EndToEnd, AnyDoublesAreRoundedOnce, ()) {
  const auto finite = rc::gen::map(rc::gen::arbitrary<std::uint64_t>(), [](std::uint64_t bits) {
    const double x = std::bit_cast<double>(bits);
    return std::isfinite(x) ? x : 1.0;
  });
  check_from_file_to_numbers(*boxes_from(finite));
}

}  // namespace
}  // namespace boxunion
