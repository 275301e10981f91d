#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/voxels/volume.hpp"
#include "host/files/input.hpp"

namespace boxunion {

/// The text at the start of a volume file, or a file of its own: lines, then fields of a name and a value.
class VolumeHeader {
 public:
  explicit VolumeHeader(std::shared_ptr<const InputFile> file);

  const InputFile& file() const { return *file_; }
  const std::shared_ptr<const InputFile>& shared_file() const { return file_; }

  /// Takes the next line, without its end; nothing at the end of the file. Throws Error(input) where the
  /// header is longer than a header may be.
  std::optional<std::string_view> take_line();
  /// Where the next line begins.
  std::uint64_t position() const { return position_; }

  /// Adds a field. Throws Error(input) if it is there already.
  void add(const std::string& field, std::string_view value);
  /// The value of a field, if it is there.
  const std::string* find(const std::string& field) const;
  /// The value of a field that must be there.
  const std::string& get(const std::string& field) const;

  /// `count` finite numbers in a field that is there; commas and parentheses count as blanks.
  std::vector<double> numbers(const std::string& field, std::size_t count) const;
  /// The extents of the three axes, checked.
  std::array<std::size_t, 3> extents(const std::string& field) const;
  /// A whole number in a field, `otherwise` if it is not there.
  std::int64_t whole(const std::string& field, std::int64_t otherwise) const;

  /// Puts the centre of the first voxel and the steps from voxel to voxel along each axis into a grid. Throws
  /// Error(input) unless each step runs along a coordinate axis of its own.
  void place(VoxelGrid& grid, const std::string& field, const std::array<std::array<double, 3>, 3>& steps,
             const std::array<double, 3>& centre) const;

  /// Opens the data file that a field names, in the header's folder if it is a relative path.
  std::shared_ptr<const InputFile> open_beside(const std::string& name,
                                               const std::atomic<bool>* interrupted) const;

 private:
  std::shared_ptr<const InputFile> file_;
  std::string text_;
  std::size_t position_ = 0;
  bool is_cut_ = false;
  std::map<std::string, std::string> fields_;
};

/// Without blanks at its ends.
std::string_view trimmed(std::string_view text);

}  // namespace boxunion
