// Runs a target without libFuzzer: on each seed, then for some seconds on random changes of them. It does not
// learn which changes reach new code, so it finds less than libFuzzer, but it needs no special build.
//
// usage: fuzz_TARGET SECONDS FOLDER INPUT [NUMBER]
//
// The seeds are in FOLDER. INPUT is a file that holds the current input, so it keeps the input that ended the
// process. NUMBER is the seed of the random numbers.

#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "tests/fuzz/fuzz.hpp"

namespace boxunion::fuzz {
namespace {

constexpr unsigned kHangSeconds = 10;
constexpr std::size_t kLongest = 4096;

std::string content(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void run(const std::string& input, const char* path) {
  std::ofstream(path, std::ios::binary) << input;
  ::alarm(kHangSeconds);
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
  ::alarm(0);
}

class Mutator {
 public:
  Mutator(std::vector<std::string> seeds, unsigned number) : seeds_(std::move(seeds)), random_(number) {}

  std::string next() {
    std::string input = seeds_[below(seeds_.size())];
    for (std::size_t changes = 1 + below(6); changes > 0; --changes) change(input);
    input.resize(std::min(input.size(), kLongest));
    return input;
  }

 private:
  std::size_t below(std::size_t limit) { return random_() % std::max<std::size_t>(limit, 1); }

  void change(std::string& input) {
    constexpr std::uint64_t kNumbers[] = {0,          1,          0x7f,        0x80,       0xff,
                                          0x7fff,     0xffff,     0x10000,     0x7fffffff, 0x80000000,
                                          0xffffffff, ~0ull >> 1, 1ull << 63u, ~0ull,      '0'};
    const std::size_t at = below(input.size()), count = std::min(1 + below(32), input.size() - at);
    switch (below(7)) {
      case 0:
        if (!input.empty()) input[at] = char(input[at] ^ 1 << below(8));
        break;
      case 1:
        if (!input.empty()) input[at] = char(below(256));
        break;
      case 2:
        if (!input.empty()) input[at] = "0123456789+-.,eE()\n \0"[below(21)];
        break;
      case 3: {
        const std::uint64_t number = kNumbers[below(std::size(kNumbers))];
        const std::size_t bytes = std::min(std::size_t{1} << below(4), input.size() - at);
        input.replace(at, bytes, reinterpret_cast<const char*>(&number), bytes);
        break;
      }
      case 4:
        input.erase(at, count);
        break;
      case 5:
        input.insert(at, input.substr(at, count));
        break;
      default: {
        const std::string& other = seeds_[below(seeds_.size())];
        input.replace(at, count, other.substr(below(other.size()), 1 + below(64)));
      }
    }
  }

  std::vector<std::string> seeds_;
  std::mt19937 random_;
};

int run_all(double seconds, const char* folder, const char* path, unsigned number) {
  std::vector<std::string> seeds;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) seeds.push_back(content(entry));
  if (seeds.empty()) seeds.emplace_back();
  std::ranges::sort(seeds);
  std::printf("%zu seeds, changed by the random numbers of %u\n", seeds.size(), number);
  std::fflush(stdout);
  for (const std::string& seed : seeds) run(seed, path);

  std::size_t runs = seeds.size();
  Mutator mutator(std::move(seeds), number);
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  for (; std::chrono::steady_clock::now() < end; ++runs) run(mutator.next(), path);
  std::printf("%zu inputs\n", runs);
  std::filesystem::remove(path);
  return 0;
}

}  // namespace
}  // namespace boxunion::fuzz

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "usage: %s SECONDS FOLDER INPUT [NUMBER]\n", argv[0]);
    return 2;
  }
  const unsigned number = argc > 4 ? unsigned(std::strtoul(argv[4], nullptr, 10)) : std::random_device()();
  return boxunion::fuzz::run_all(std::strtod(argv[1], nullptr), argv[2], argv[3], number);
}
