#include "host/files/formats.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <set>
#include <string>

namespace boxunion {
namespace {

std::string text_of(const std::string& path) {
  std::ifstream file(BOXUNION_SOURCE "/" + path);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Formats, AnExtensionNamesOneOfThem) {
  std::set<std::string_view> seen;
  for (const Format& format : formats())
    for (const std::string_view extension : format.extensions) {
      if (extension.empty()) continue;
      EXPECT_TRUE(extension.starts_with('.'));
      EXPECT_TRUE(seen.insert(extension).second) << extension;
    }
}

TEST(Formats, AllAreDocumented) {
  const std::string text = text_of("docs/formats.md");
  for (const Format& format : formats())
    for (const std::string_view extension : format.extensions) {
      if (extension.empty()) continue;
      EXPECT_TRUE(text.find("`" + std::string(extension) + "`") != text.npos) << extension;
    }
}

TEST(Formats, AllThatAreReadAreFuzzed) {
  std::string read;  // formats that tests/fuzz/CMakeLists.txt should find in the table
  for (const Format& format : formats())
    if (format.serves(FileUse::input))
      read += (read.empty() ? "" : " ") + std::string(format.extensions[0].substr(1));
  EXPECT_EQ(BOXUNION_FUZZED_FORMATS, read);
}

TEST(Formats, AllThatAreReadHaveAReader) {
  for (const Format& format : formats())
    EXPECT_EQ(format.reader != nullptr || !format.missing.empty(), format.serves(FileUse::input))
        << format.extensions[0];
}

}  // namespace
}  // namespace boxunion
