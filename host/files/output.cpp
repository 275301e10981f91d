#include "host/files/output.hpp"

#include <fmt/format.h>

#include <utility>

#include "boxunion/error.hpp"
#include "core/base/interruptible.hpp"

namespace boxunion {
namespace {

constexpr std::size_t kBufferBytes = 1 << 20;

}  // namespace

void OutputGroup::enter(const PendingFile& file) {
  for (const auto& [path, target] : entered_)
    if (target == file.target())
      throw Error(ErrorKind::usage, fmt::format("{} and {} are the same file, expected one for each output",
                                                path, file.path()));
  entered_.emplace_back(file.path(), file.target());
}

void OutputGroup::publish() {
  for (PendingFile& file : committed_) file.publish();
  committed_.clear();
}

OutputFile::OutputFile(std::string path, OutputGroup* group) : file_(std::move(path)), group_(group) {
  if (group_) group_->enter(file_);
  buffer_.reserve(kBufferBytes);
}

void OutputFile::write(std::string_view text) {
  Interruptible::check();
  if (buffer_.size() + text.size() <= kBufferBytes) {
    buffer_.append(text);
    return;
  }
  flush();
  if (text.size() < kBufferBytes) {
    buffer_.append(text);
    return;
  }
  write_at(written_, text);
  written_ += text.size();
}

void OutputFile::overwrite(std::uint64_t offset, std::string_view text) {
  flush();
  write_at(offset, text);
}

void OutputFile::flush() {
  write_at(written_, buffer_);
  written_ += buffer_.size();
  buffer_.clear();
}

void OutputFile::write_at(std::uint64_t offset, std::string_view text) {
  while (!text.empty()) {
    const std::size_t written = file_.write_at(offset, text);
    offset += written;
    text.remove_prefix(written);
    if (written == 0) Interruptible::check();
  }
}

void OutputFile::commit() {
  flush();
  file_.check_written();
  if (group_)
    group_->committed_.push_back(std::move(file_));
  else
    file_.publish();
}

}  // namespace boxunion
