#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "host/device/backend.hpp"

namespace boxunion {
namespace {

TEST(Backends, NativeIsBuiltInAndFirst) {
  EXPECT_EQ(backends().front().kind, "native");
  EXPECT_NE(backends().front().open, nullptr);
}

TEST(Backends, AllAreDocumented) {
  for (const std::string page : {"/docs/devices.md", "/README.md"}) {
    std::ifstream file(BOXUNION_SOURCE + page);
    const std::string text(std::istreambuf_iterator<char>(file), {});
    for (const Backend& backend : backends())
      EXPECT_TRUE(text.find("| `" + std::string(backend.kind)) != text.npos)
          << backend.kind << " in " << page;
  }
}

TEST(Backends, OneThatIsNotBuiltInHasNoDevicesAndANote) {
  std::vector<std::string> notes;
  EXPECT_TRUE(list_devices(Backend{"none", "None"}, notes).empty());
  EXPECT_EQ(notes, std::vector<std::string>{"None: not built in"});
}

}  // namespace
}  // namespace boxunion
