#pragma once

#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace boxunion {

/// Numbers as bytes of a file, in the other byte order if `swapped`.
template <class T>
std::string bytes(const std::vector<T>& values, bool swapped = false) {
  std::string all;
  for (const T value : values) {
    auto b = std::bit_cast<std::array<char, sizeof(T)>>(value);
    if (swapped) std::reverse(b.begin(), b.end());
    all.append(b.data(), b.size());
  }
  return all;
}

/// A folder for the files of a test. The destructor removes it with its contents.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    path_ = (std::filesystem::temp_directory_path() / "boxunion-XXXXXX").string();
    if (!::mkdtemp(path_.data())) throw std::runtime_error("cannot create " + path_);
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::string& path() const { return path_; }
  std::string file(std::string_view name) const { return path_ + "/" + std::string(name); }
  /// Writes a file and returns its path.
  std::string write(std::string_view name, std::string_view content) const {
    std::ofstream(file(name), std::ios::binary) << content;
    return file(name);
  }
  std::string read(std::string_view name) const {
    std::ifstream stream(file(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  /// True if its file system supports nameless files.
  bool has_nameless_files() const {
    const int file = ::open(path_.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0600);
    return file >= 0 && ::close(file) == 0;
  }
  std::size_t file_count() const {
    return std::size_t(std::distance(std::filesystem::directory_iterator(path_), {}));
  }

 private:
  std::string path_;
};

}  // namespace boxunion
