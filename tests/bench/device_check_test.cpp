// The self-test of devices: correct devices pass; a device that fails or gives wrong results does not.

#include "host/bench/device_check.hpp"

#include <gtest/gtest.h>

#include "boxunion/error.hpp"
#include "host/bench/kernel_bench.hpp"
#include "tests/command/command.hpp"
#include "tests/device/native_proxy.hpp"

namespace boxunion {
namespace {

std::vector<std::string> names(const std::vector<KernelCheck>& checks) {
  std::vector<std::string> names;
  for (const KernelCheck& check : checks) names.push_back(check.kernel);
  return names;
}

const std::vector<std::string> kKernels(benchmark_kernels().begin(), benchmark_kernels().end());

TEST(DeviceCheck, NativeKernelsAgreeWithBruteForce) {
  const auto checks = check_native_kernels();
  EXPECT_EQ(names(checks), kKernels);
  for (const KernelCheck& check : checks) EXPECT_EQ(check.failure, "") << check.kernel;
}

TEST(DeviceCheck, ADeviceWithoutFaultPasses) {
  NativeProxy device;
  const auto checks = check_kernels(device);
  EXPECT_EQ(names(checks), kKernels);
  for (const KernelCheck& check : checks) EXPECT_EQ(check.failure, "") << check.kernel;
}

TEST(DeviceCheck, OneWrongBitOfAResultIsNoticedInEveryKernel) {
  class : public NativeProxy {
    void download(Buffer& buffer, std::size_t offset, std::size_t bytes) override {
      NativeProxy::download(buffer, offset, bytes);
      if (bytes > 2 * sizeof(std::uint32_t)) buffer.view<std::uint32_t>()[offset / 4] ^= 1u;
    }
  } wrong;
  for (const KernelCheck& check : check_kernels(wrong)) {
    EXPECT_NE(check.failure, "") << check.kernel;
    if (check.kernel == "contour") continue;  // its stage already rejects such a result
    EXPECT_EQ(check.failure, "wrong result: it differs from the native device's") << check.kernel;
  }
}

TEST(DeviceCheck, AKernelThatFailsDoesNotHideTheOthers) {
  class : public NativeProxy {
    std::unique_ptr<Kernel> load(const KernelSource& source, Shape shape, std::uint32_t workgroup) override {
      if (source.name == "cell_faces") throw Error(ErrorKind::device, "no faces");
      return NativeProxy::load(source, shape, workgroup);
    }
  } broken;
  const DeviceCheck check{.info = broken.info(), .kernels = check_kernels(broken)};
  EXPECT_FALSE(check.is_ok());
  for (const KernelCheck& kernel : check.kernels)
    EXPECT_EQ(kernel.failure, kernel.kernel == "cell_faces" ? "no faces" : "") << kernel.kernel;
}

TEST_F(Command, DevicesAreCheckedAndOneThatFailsExitsWith4) {
  const nlohmann::json result = json("devices --check --json");
  for (const nlohmann::json& device : result.at("devices")) {
    EXPECT_EQ(device.at("ok"), true) << device;
    EXPECT_EQ(device.at("kernels").size(), kKernels.size()) << device;
  }
  if (result.at("devices").size() == 1) return;
  const std::string id = result.at("devices").at(1).at("id");
  const Outcome failed = shell("BOXUNION_FAIL_DEVICE=dispatch:2 boxunion devices --check");
  EXPECT_EQ(failed.status, 4);
  EXPECT_TRUE(failed.out.starts_with("native      ok\n")) << failed.out;
  EXPECT_NE(failed.out.find("\n" + id), std::string::npos) << failed.out;
  EXPECT_NE(failed.out.find("FAILED\n            contour: " + id + ": injected failure of dispatch\n"),
            std::string::npos)
      << failed.out;
  EXPECT_TRUE(failed.err.starts_with("boxunion: error: " + id)) << failed.err;
  EXPECT_TRUE(failed.err.ends_with(" failed the check\n")) << failed.err;
}

}  // namespace
}  // namespace boxunion
