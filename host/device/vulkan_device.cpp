#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "boxunion/error.hpp"
#include "host/device/backend.hpp"
#include "host/device/vulkan_session.hpp"

namespace boxunion {
namespace {

using namespace vulkan;

/// Maximum number of dispatches between two waits, for which the descriptor and query pools have room.
/// Another one first waits for the others.
constexpr std::uint32_t max_dispatches = 256;
constexpr std::uint32_t max_bindings = 16;

DeviceInfo describe(VkPhysicalDevice device, std::size_t index) {
  auto driver =
      structure<VkPhysicalDeviceDriverProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES);
  auto maintenance = structure<VkPhysicalDeviceMaintenance3Properties>(
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES, &driver);
  auto properties =
      structure<VkPhysicalDeviceProperties2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &maintenance);
  vkGetPhysicalDeviceProperties2(device, &properties);
  const VkPhysicalDeviceProperties& core = properties.properties;
  VkPhysicalDeviceMemoryProperties memory;
  vkGetPhysicalDeviceMemoryProperties(device, &memory);

  DeviceInfo info;
  info.id = fmt::format("vulkan:{}", index);
  info.name = core.deviceName;
  info.driver =
      fmt::format("Vulkan {}.{}.{}, {} {}", VK_API_VERSION_MAJOR(core.apiVersion),
                  VK_API_VERSION_MINOR(core.apiVersion), VK_API_VERSION_PATCH(core.apiVersion),
                  static_cast<const char*>(driver.driverName), static_cast<const char*>(driver.driverInfo));
  info.is_cpu = core.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
  info.is_unified = info.is_cpu || core.deviceType == VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU;
  info.max_buffer_bytes =
      std::min<std::size_t>(core.limits.maxStorageBufferRange, maintenance.maxMemoryAllocationSize);
  info.max_workgroup =
      std::min(core.limits.maxComputeWorkGroupInvocations, core.limits.maxComputeWorkGroupSize[0]);
  for (std::uint32_t heap = 0; heap < memory.memoryHeapCount; ++heap)
    if ((memory.memoryHeaps[heap].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) != 0)
      info.memory_bytes = std::max(info.memory_bytes, memory.memoryHeaps[heap].size);
  // A CPU driver pays for every work-item of a group at every barrier, so one work-item per unit is fastest,
  // in groups of its vector width. A GPU needs lanes that do the same thing.
  info.preferred_shape = info.is_cpu ? Shape::item : Shape::group;
  info.preferred_workgroup = std::min(info.is_cpu ? 8u : 64u, info.max_workgroup);
  return info;
}

/// A buffer in mapped memory and, unless kernels use that directly, a second one in the device's own memory.
class VulkanBuffer final : public Buffer {
 public:
  VulkanBuffer(std::shared_ptr<Session> session, std::size_t bytes, bool zero_copy)
      : session_(std::move(session)), zero_copy_(zero_copy) {
    auto info = structure<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
    info.size = round_up(bytes, sizeof(std::uint32_t));
    info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
                 VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    const VkDevice device = session_->device();
    mapped_ = BufferHandle::make(device, vkCreateBuffer, info, "vkCreateBuffer");
    mapped_memory_ = session_->allocate(
        mapped_.get(), VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
        VK_MEMORY_PROPERTY_HOST_CACHED_BIT);
    check(vkMapMemory(device, mapped_memory_.get(), 0, VK_WHOLE_SIZE, 0, &host_), "vkMapMemory");
    bytes_ = bytes;
    if (zero_copy) return;
    local_ = BufferHandle::make(device, vkCreateBuffer, info, "vkCreateBuffer");
    local_memory_ = session_->allocate(local_.get(), 0, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
  }
  ~VulkanBuffer() override { session_->finish(); }  // after an exception, the device may still be working

  VkBuffer mapped() const { return mapped_.get(); }
  VkBuffer handle() const { return zero_copy_ ? mapped_.get() : local_.get(); }
  bool zero_copy() const { return zero_copy_; }

 private:
  std::shared_ptr<Session> session_;
  Memory mapped_memory_, local_memory_;
  BufferHandle mapped_, local_;
  bool zero_copy_;
};

struct VulkanKernel final : Kernel {
  VulkanKernel(std::shared_ptr<Session> session, const KernelSource& source, Shape shape,
               std::uint32_t workgroup)
      : session(std::move(session)),
        source(source),
        shape(shape),
        workgroup(workgroup),
        program(this->session->logical().program(source, shape, workgroup)) {}
  std::shared_ptr<Session> session;
  const KernelSource& source;
  Shape shape;
  std::uint32_t workgroup;
  const Program& program;
};

/// A Vulkan 1.2 device with one queue. Uploads and clears are submitted with the next dispatch or download.
class VulkanDevice final : public Device {
 public:
  VulkanDevice(std::shared_ptr<LogicalDevice> logical, std::size_t index, ZeroCopy zero_copy)
      : info_(describe(logical->physical(), index)) {
    if (zero_copy == ZeroCopy::never) info_.is_unified = false;
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(logical->physical(), &properties);
    max_groups_x_ = properties.limits.maxComputeWorkGroupCount[0];
    tick_seconds_ = properties.limits.timestampComputeAndGraphics == VK_TRUE
                        ? 1e-9 * static_cast<double>(properties.limits.timestampPeriod)
                        : 0;
    session_ = std::make_shared<Session>(std::move(logical));

    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, max_dispatches * max_bindings};
    auto pool = structure<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
    pool.maxSets = max_dispatches;
    pool.poolSizeCount = 1;
    pool.pPoolSizes = &size;
    descriptors_ =
        DescriptorPool::make(session_->device(), vkCreateDescriptorPool, pool, "vkCreateDescriptorPool");
    auto queries = structure<VkQueryPoolCreateInfo>(VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO);
    queries.queryType = VK_QUERY_TYPE_TIMESTAMP;
    queries.queryCount = 2 * max_dispatches;
    timestamps_ = QueryPool::make(session_->device(), vkCreateQueryPool, queries, "vkCreateQueryPool");
  }
  ~VulkanDevice() override { session_->finish(); }

  const DeviceInfo& info() const override { return info_; }

  std::unique_ptr<Buffer> allocate(std::size_t bytes) override {
    check_allocation(info_, bytes);
    return std::make_unique<VulkanBuffer>(session_, bytes, info_.is_unified);
  }

  void upload(Buffer& buffer, std::size_t bytes) override {
    auto& target = static_cast<VulkanBuffer&>(buffer);
    if (target.zero_copy() || bytes == 0) return;
    const VkBufferCopy region{0, 0, bytes};
    vkCmdCopyBuffer(session_->record(), target.mapped(), target.handle(), 1, &region);
  }

  void download(Buffer& buffer, std::size_t offset, std::size_t bytes) override {
    auto& source = static_cast<VulkanBuffer&>(buffer);
    if (bytes == 0) return;
    const VkCommandBuffer commands = session_->record();
    const VkBufferCopy region{offset, offset, bytes};
    if (!source.zero_copy()) vkCmdCopyBuffer(commands, source.handle(), source.mapped(), 1, &region);
    session_->release_to_host();
    check(session_->submit(), "vkQueueSubmit");
  }

  void clear(Buffer& buffer, std::size_t bytes) override {
    const VkBuffer target = static_cast<VulkanBuffer&>(buffer).handle();
    if (bytes == 0) return;
    vkCmdFillBuffer(session_->record(), target, 0, round_up(bytes, sizeof(std::uint32_t)), 0);
  }

  std::unique_ptr<Kernel> load(const KernelSource& source, Shape shape, std::uint32_t workgroup) override {
    check_workgroup(info_, shape, workgroup);
    return std::make_unique<VulkanKernel>(session_, source, shape, workgroup);
  }

  void dispatch(Kernel& kernel, std::span<Buffer* const> buffers, std::span<const std::byte> parameters,
                std::uint32_t units) override {
    auto& loaded = static_cast<VulkanKernel&>(kernel);
    check_dispatch(loaded.source, buffers.size(), parameters.size(), units);
    if (units == 0) return;
    if (dispatched_ == max_dispatches) wait();

    const VkDescriptorSet set = bind(loaded.program.set_layout.get(), buffers);
    const std::uint32_t groups =
        loaded.shape == Shape::group ? units : (units + loaded.workgroup - 1) / loaded.workgroup;
    const std::uint32_t groups_x =
        std::min(groups, max_groups_x_);  // GROUP_INDEX of the dialect is x + width * y
    const std::uint32_t groups_y = (groups + groups_x - 1) / groups_x;

    const VkCommandBuffer commands = session_->record();
    const std::uint32_t query = 2 * dispatched_++;
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, loaded.program.pipeline.get());
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, loaded.program.layout.get(), 0, 1, &set,
                            0, nullptr);
    vkCmdPushConstants(commands, loaded.program.layout.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0,
                       static_cast<std::uint32_t>(parameters.size()), parameters.data());
    vkCmdResetQueryPool(commands, timestamps_.get(), query, 2);
    vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, timestamps_.get(), query);
    vkCmdDispatch(commands, groups_x, groups_y, 1);
    vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, timestamps_.get(), query + 1);
    check(session_->submit(), "vkQueueSubmit");
  }

  void wait() override {
    check(session_->finish(), "vkWaitForFences");
    const std::uint32_t dispatched = std::exchange(dispatched_, 0);
    check(vkResetDescriptorPool(session_->device(), descriptors_.get(), 0), "vkResetDescriptorPool");
    std::vector<std::uint64_t> ticks(2 * dispatched);
    if (dispatched != 0 && tick_seconds_ != 0)
      check(vkGetQueryPoolResults(session_->device(), timestamps_.get(), 0, 2 * dispatched,
                                  ticks.size() * sizeof ticks[0], ticks.data(), sizeof ticks[0],
                                  VK_QUERY_RESULT_64_BIT),
            "vkGetQueryPoolResults");
    for (std::size_t i = 0; i < ticks.size(); i += 2)
      seconds_ += tick_seconds_ * static_cast<double>(ticks[i + 1] - ticks[i]);
    session_->logical().instance().check_messages();
  }

  double kernel_seconds() const override { return seconds_; }

 private:
  VkDescriptorSet bind(VkDescriptorSetLayout layout, std::span<Buffer* const> buffers) {
    auto info = structure<VkDescriptorSetAllocateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO);
    info.descriptorPool = descriptors_.get();
    info.descriptorSetCount = 1;
    info.pSetLayouts = &layout;
    VkDescriptorSet set = VK_NULL_HANDLE;
    check(vkAllocateDescriptorSets(session_->device(), &info, &set), "vkAllocateDescriptorSets");
    std::vector<VkDescriptorBufferInfo> ranges;
    for (Buffer* buffer : buffers)
      ranges.push_back({static_cast<VulkanBuffer*>(buffer)->handle(), 0, VK_WHOLE_SIZE});
    auto write = structure<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
    write.dstSet = set;
    write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    for (const VkDescriptorBufferInfo& range : ranges) {
      write.descriptorCount = 1;
      write.pBufferInfo = &range;
      vkUpdateDescriptorSets(session_->device(), 1, &write, 0, nullptr);
      ++write.dstBinding;
    }
    return set;
  }

  DeviceInfo info_;
  std::uint32_t max_groups_x_ = 0;
  double tick_seconds_ = 0;
  std::shared_ptr<Session> session_;
  DescriptorPool descriptors_;
  QueryPool timestamps_;
  std::uint32_t dispatched_ = 0;  // since the last wait()
  double seconds_ = 0;
};

}  // namespace

std::vector<DeviceInfo> list_vulkan(std::vector<std::string>& notes) {
  std::vector<DeviceInfo> infos;
  if (!process.claim()) {
    notes.push_back(used_before_fork("Vulkan"));
    return infos;
  }
  try {
    const std::shared_ptr<Instance> instance = shared_instance();
    for (VkPhysicalDevice device : find_devices(instance->get(), notes))
      infos.push_back(describe(device, infos.size()));
  } catch (const Error& error) {
    notes.push_back(fmt::format("{}: install a driver such as mesa-vulkan-drivers", error.what()));
  }
  return infos;
}

std::unique_ptr<Device> open_vulkan(std::size_t index, ZeroCopy zero_copy) {
  return std::make_unique<VulkanDevice>(logical_device(index), index, zero_copy);
}

}  // namespace boxunion
