#include "host/files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/error.hpp"
#include "host/formats.hpp"

namespace boxunion {

FileFormat file_format(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return 'A' <= c && c <= 'Z' ? char(c + 'a' - 'A') : c; });
  if (extension == ".csv") return FileFormat::csv;
  if (extension == ".npy") return FileFormat::npy;
  throw Error(ErrorKind::input,
              extension.empty()
                  ? fmt::format("{}: no file extension, expected .csv or .npy", path)
                  : fmt::format("{}: unknown extension {}, expected .csv or .npy", path, extension));
}

BoxSet read_boxes(const std::string& path, const std::atomic<bool>* interrupted) {
  const FileFormat format = path == "-" ? FileFormat::csv : file_format(path);
  InputFile file(path, interrupted);
  return format == FileFormat::csv ? csv::read_boxes(file) : npy::read_boxes(file);
}

OutputFile open_output(const std::string& path, const std::atomic<bool>* interrupted) {
  file_format(path);
  return OutputFile(path, interrupted);
}

template <class T>
BoxWriter<T>::BoxWriter(OutputFile& file, std::uint64_t count)
    : file_(file), format_(file_format(file.path())) {
  if (format_ == FileFormat::csv)
    csv::write_box_header(file_);
  else
    npy::write_box_header<T>(file_, count);
}

template <class T>
void BoxWriter<T>::write(std::span<const BoxOf<T>> boxes) {
  if (format_ == FileFormat::csv)
    csv::write_box_rows(file_, boxes);
  else
    npy::write_box_rows(file_, boxes);
}

template class BoxWriter<double>;
template class BoxWriter<std::int32_t>;

void write_boxes(const BoxSet& set, OutputFile file) {
  set.visit(
      [&]<class T>(const std::vector<BoxOf<T>>& boxes) { BoxWriter<T>(file, boxes.size()).write(boxes); });
  file.commit();
}

void write_vertices(const Solid& solid, OutputFile file) {
  if (file_format(file.path()) == FileFormat::csv)
    csv::write_vertices(file, solid);
  else
    npy::write_vertices(file, solid);
  file.commit();
}

}  // namespace boxunion
