#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "boxunion/volume.hpp"
#include "host/files/input.hpp"

namespace boxunion {

/// The header of a volume, at the start of its file or in a file of its own: lines, then fields of a name and
/// a value.
class VolumeHeader {
 public:
  explicit VolumeHeader(std::shared_ptr<const InputFile> file);

  const InputFile& file() const { return *file_; }
  const std::shared_ptr<const InputFile>& shared_file() const { return file_; }

  /// Removes the next line and returns it without its end; nothing at the end of the file. Throws
  /// Error(input) if the header is too long.
  std::optional<std::string_view> take_line();
  /// The offset of the next line.
  std::uint64_t position() const { return position_; }

  /// Adds a field. Throws Error(input) if it exists already.
  void add(const std::string& field, std::string_view value);
  /// The value of a field, or null.
  const std::string* find(const std::string& field) const;
  /// The value of a required field.
  const std::string& get(const std::string& field) const;

  /// The `count` finite numbers of a required field. Commas and parentheses count as blanks.
  std::vector<double> numbers(const std::string& field, std::size_t count) const;
  /// The extents of the three axes, checked.
  std::array<std::size_t, 3> extents(const std::string& field) const;
  /// The whole number in a field, or `otherwise` if the field is missing.
  std::int64_t whole(const std::string& field, std::int64_t otherwise) const;

  /// Sets the centre of the first voxel and the steps from voxel to voxel along each axis of a grid. Throws
  /// Error(input) unless each step runs along a coordinate axis of its own.
  void place(VoxelGrid& grid, const std::string& field, const std::array<std::array<double, 3>, 3>& steps,
             const std::array<double, 3>& centre) const;

  /// Opens the data file that a field names. A relative path is relative to the folder of the header.
  std::shared_ptr<const InputFile> open_beside(const std::string& name) const;

 private:
  std::shared_ptr<const InputFile> file_;
  std::string text_;
  std::size_t position_ = 0;
  bool is_cut_ = false;
  std::map<std::string, std::string> fields_;
};

/// The text without blanks at its ends.
std::string_view trimmed(std::string_view text);

}  // namespace boxunion
