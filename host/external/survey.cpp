#include "host/external/survey.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <exception>
#include <limits>
#include <mutex>

#include "boxunion/error.hpp"
#include "core/base/parallel.hpp"
#include "core/base/sample.hpp"

namespace boxunion {

bool Survey::are_long() const {
  // The mean extent of long boxes on their longest axis, as a fraction of the whole.
  constexpr double kLong = 0.1;
  std::array<double, 3> lo, hi;
  lo.fill(std::numeric_limits<double>::max());
  hi.fill(std::numeric_limits<double>::lowest());
  for (const Box& box : sample)
    for (unsigned a = 0; a < 3; ++a) lo[a] = std::min(lo[a], box[a]), hi[a] = std::max(hi[a], box[a + 3]);
  double sum = 0;
  for (const Box& box : sample) {
    double longest = 0;  // halved, because differences may overflow
    for (unsigned a = 0; a < 3; ++a)
      if (hi[a] > lo[a]) longest = std::max(longest, (box[a + 3] / 2 - box[a] / 2) / (hi[a] / 2 - lo[a] / 2));
    sum += longest;
  }
  return sum > kLong * double(sample.size());
}

Survey survey_boxes(const BoxFile& file, BoxSummer* sums) {
  constexpr std::uint64_t kPiece = BoxSource<double>::kPiece;
  const Sample sample(file.size(), BoxSource<double>::kSample);
  PerThread<Survey> parts;
  std::mutex mutex;
  std::atomic<std::uint64_t> bad_piece = std::numeric_limits<std::uint64_t>::max();
  std::exception_ptr error;
  const auto look = [&](std::uint64_t begin, Survey& part) {
    const BoxSet boxes = file.read(begin, std::min(begin + kPiece, file.size()));
    const std::size_t invalid = find_invalid(boxes);
    if (invalid < boxes.size()) validate(boxes[invalid], file.name_of(begin + invalid));
    part.lattices.add(boxes);
    part.degenerate += count_degenerate(boxes);
    if (sums) sums->add(boxes);
    sample.each(begin, begin + boxes.size(), [&](std::uint64_t i) {
      if (const Box box = boxes[i - begin]; !is_degenerate(box)) part.sample.push_back(box);
    });
  };
  parallel_ranges(0, (file.size() + kPiece - 1) / kPiece, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t piece = begin; piece < end && piece < bad_piece; ++piece) try {
        look(piece * kPiece, parts.local());
      } catch (const Error& e) {
        if (e.kind() != ErrorKind::input) throw;
        const std::lock_guard lock(mutex);
        if (piece < bad_piece) bad_piece = piece, error = std::current_exception();
      }
  });
  if (error) std::rethrow_exception(error);
  Survey all;
  parts.for_each([&](const Survey& part) { all.join(part); });
  return all;
}

}  // namespace boxunion
