#include <fmt/format.h>
#include <vulkan/vulkan.h>

#include <algorithm>
#include <cstring>
#include <mutex>
#include <optional>
#include <utility>

#include "core/error.hpp"
#include "host/backend.hpp"

namespace boxunion {
namespace {

/// Dispatches between two waits: what the descriptor and query pools hold. One more waits for the others
/// first.
constexpr std::uint32_t max_dispatches = 256;
constexpr std::uint32_t max_bindings = 16;

void check(VkResult result, const char* call) {
  if (result == VK_SUCCESS) return;
  const bool memory = result == VK_ERROR_OUT_OF_HOST_MEMORY || result == VK_ERROR_OUT_OF_DEVICE_MEMORY;
  const char* what = memory                                 ? "out of memory"
                     : result == VK_ERROR_DEVICE_LOST       ? "device lost"
                     : result == VK_ERROR_LAYER_NOT_PRESENT ? "layer not present"
                                                            : "error";
  throw Error(memory ? ErrorKind::resources : ErrorKind::device,
              fmt::format("Vulkan: {}: {} ({})", call, what, static_cast<int>(result)));
}

/// A structure of Vulkan's, zero but for its type.
template <class T>
T structure(VkStructureType type, void* next = nullptr) {
  T empty{};
  empty.sType = type;
  empty.pNext = next;
  return empty;
}

/// Owns a handle that belongs to a VkDevice.
template <class T, auto destroy>
class Handle {
 public:
  Handle() = default;
  Handle(VkDevice device, T handle) : device_(device), handle_(handle) {}
  Handle(Handle&& other) noexcept
      : device_(other.device_), handle_(std::exchange(other.handle_, VK_NULL_HANDLE)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Handle() {
    if (handle_ != VK_NULL_HANDLE) destroy(device_, handle_, nullptr);
  }
  T get() const { return handle_; }

  /// A new object: create is the vkCreate... or vkAllocate... function.
  template <class Create, class Info>
  static Handle make(VkDevice device, Create create, const Info& info, const char* call) {
    T handle = VK_NULL_HANDLE;
    check(create(device, &info, nullptr, &handle), call);
    return {device, handle};
  }

 private:
  VkDevice device_ = VK_NULL_HANDLE;
  T handle_ = VK_NULL_HANDLE;
};
using BufferHandle = Handle<VkBuffer, vkDestroyBuffer>;
using Memory = Handle<VkDeviceMemory, vkFreeMemory>;
using ShaderModule = Handle<VkShaderModule, vkDestroyShaderModule>;
using SetLayout = Handle<VkDescriptorSetLayout, vkDestroyDescriptorSetLayout>;
using PipelineLayout = Handle<VkPipelineLayout, vkDestroyPipelineLayout>;
using Pipeline = Handle<VkPipeline, vkDestroyPipeline>;
using DescriptorPool = Handle<VkDescriptorPool, vkDestroyDescriptorPool>;
using CommandPool = Handle<VkCommandPool, vkDestroyCommandPool>;
using QueryPool = Handle<VkQueryPool, vkDestroyQueryPool>;

/// A VkInstance; with BOXUNION_VULKAN_VALIDATION=1 it also collects what the validation layer says.
class Instance {
 public:
  Instance() {
    auto application = structure<VkApplicationInfo>(VK_STRUCTURE_TYPE_APPLICATION_INFO);
    application.pApplicationName = "boxunion";
    application.apiVersion = VK_API_VERSION_1_2;
    auto create = structure<VkInstanceCreateInfo>(VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO);
    create.pApplicationInfo = &application;

    const char* layer = "VK_LAYER_KHRONOS_validation";
    const char* extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
    const VkValidationFeatureEnableEXT enabled[] = {
        VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT,
        VK_VALIDATION_FEATURE_ENABLE_GPU_ASSISTED_EXT,
        VK_VALIDATION_FEATURE_ENABLE_GPU_ASSISTED_RESERVE_BINDING_SLOT_EXT};
    auto features = structure<VkValidationFeaturesEXT>(VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT);
    features.enabledValidationFeatureCount = 3;
    features.pEnabledValidationFeatures = enabled;
    auto messenger = structure<VkDebugUtilsMessengerCreateInfoEXT>(
        VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT);
    messenger.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    messenger.pfnUserCallback = &Instance::receive;
    messenger.pUserData = this;

    const bool validation = environment_flag("BOXUNION_VULKAN_VALIDATION");
    if (validation) {
      create.enabledLayerCount = 1;
      create.ppEnabledLayerNames = &layer;
      create.enabledExtensionCount = 2;
      create.ppEnabledExtensionNames = extensions;
      create.pNext = &features;
    }
    check(vkCreateInstance(&create, nullptr, &handle_), "vkCreateInstance");
    if (validation) {
      const auto make = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
          vkGetInstanceProcAddr(handle_, "vkCreateDebugUtilsMessengerEXT"));
      make(handle_, &messenger, nullptr, &messenger_);
    }
  }
  ~Instance() {
    if (messenger_ != VK_NULL_HANDLE) {
      const auto destroy = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
          vkGetInstanceProcAddr(handle_, "vkDestroyDebugUtilsMessengerEXT"));
      destroy(handle_, messenger_, nullptr);
    }
    if (handle_ != VK_NULL_HANDLE) vkDestroyInstance(handle_, nullptr);
  }
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;
  VkInstance get() const { return handle_; }

  /// Throws Error(device) with the first message since the last call, if there was one.
  void check_messages() {
    const std::lock_guard lock(mutex_);
    if (messages_.empty()) return;
    const std::string first = std::exchange(messages_, {}).front();
    throw Error(ErrorKind::device, "Vulkan validation: " + first);
  }

 private:
  static VKAPI_ATTR VkBool32 VKAPI_CALL receive(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                                VkDebugUtilsMessageTypeFlagsEXT,
                                                const VkDebugUtilsMessengerCallbackDataEXT* data,
                                                void* self) {
    auto& instance = *static_cast<Instance*>(self);
    const std::lock_guard lock(instance.mutex_);
    instance.messages_.emplace_back(data->pMessage);
    return VK_FALSE;
  }

  VkInstance handle_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  std::mutex mutex_;
  std::vector<std::string> messages_;
};

/// The first queue family that computes.
std::optional<std::uint32_t> compute_family(VkPhysicalDevice device) {
  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
  for (std::uint32_t family = 0; family < count; ++family)
    if ((families[family].queueFlags & VK_QUEUE_COMPUTE_BIT) != 0) return family;
  return std::nullopt;
}

/// Every device that offers what the kernels' SPIR-V needs: Vulkan 1.2 and 64-bit integers.
std::vector<VkPhysicalDevice> find_devices(VkInstance instance, std::vector<std::string>& notes) {
  std::uint32_t count = 0;
  check(vkEnumeratePhysicalDevices(instance, &count, nullptr), "vkEnumeratePhysicalDevices");
  std::vector<VkPhysicalDevice> devices(count);
  if (count != 0)
    check(vkEnumeratePhysicalDevices(instance, &count, devices.data()), "vkEnumeratePhysicalDevices");
  if (count == 0) notes.emplace_back("Vulkan: no device found: install a driver such as mesa-vulkan-drivers");
  std::erase_if(devices, [&](VkPhysicalDevice device) {
    VkPhysicalDeviceProperties properties;
    VkPhysicalDeviceFeatures features;
    vkGetPhysicalDeviceProperties(device, &properties);
    vkGetPhysicalDeviceFeatures(device, &features);
    const bool usable = properties.apiVersion >= VK_API_VERSION_1_2 && features.shaderInt64 == VK_TRUE &&
                        compute_family(device).has_value();
    if (!usable)
      notes.push_back(fmt::format("Vulkan: {} lacks Vulkan 1.2, 64-bit integers or compute",
                                  static_cast<const char*>(properties.deviceName)));
    return !usable;
  });
  return devices;
}

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
  // A CPU driver pays for every work-item of a group at every barrier, so one work-item a unit is fastest, in
  // groups of its vector width. A GPU needs lanes that do the same thing.
  info.preferred_shape = info.is_cpu ? Shape::item : Shape::group;
  info.preferred_workgroup = std::min(info.is_cpu ? 8u : 64u, info.max_workgroup);
  return info;
}

/// What a device, its buffers and its kernels share, so that they may be destroyed in any order: the logical
/// device, its queue and the commands that are being recorded or run.
class Session {
 public:
  Session(std::unique_ptr<Instance> instance, VkPhysicalDevice physical)
      : instance_(std::move(instance)), physical_(physical), family_(compute_family(physical).value()) {
    const float priority = 1;
    auto queue = structure<VkDeviceQueueCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO);
    queue.queueFamilyIndex = family_;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    VkPhysicalDeviceFeatures features{};
    features.shaderInt64 = VK_TRUE;
    auto create = structure<VkDeviceCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO);
    create.queueCreateInfoCount = 1;
    create.pQueueCreateInfos = &queue;
    create.pEnabledFeatures = &features;
    check(vkCreateDevice(physical, &create, nullptr, &device_), "vkCreateDevice");
    vkGetDeviceQueue(device_, family_, 0, &queue_);
  }
  ~Session() {
    pool_ = {};
    vkDestroyDevice(device_, nullptr);
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  VkDevice device() const { return device_; }
  std::uint32_t family() const { return family_; }
  Instance& instance() { return *instance_; }

  /// Memory of a type that has all `required` flags and, if there is such a type, the `preferred` ones.
  Memory allocate(VkBuffer buffer, VkMemoryPropertyFlags required, VkMemoryPropertyFlags preferred) {
    VkMemoryRequirements requirements;
    vkGetBufferMemoryRequirements(device_, buffer, &requirements);
    VkPhysicalDeviceMemoryProperties properties;
    vkGetPhysicalDeviceMemoryProperties(physical_, &properties);
    for (const VkMemoryPropertyFlags wanted : {required | preferred, required})
      for (std::uint32_t type = 0; type < properties.memoryTypeCount; ++type) {
        if ((requirements.memoryTypeBits >> type & 1u) == 0) continue;
        if ((properties.memoryTypes[type].propertyFlags & wanted) != wanted) continue;
        auto info = structure<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
        info.allocationSize = requirements.size;
        info.memoryTypeIndex = type;
        Memory memory = Memory::make(device_, vkAllocateMemory, info, "vkAllocateMemory");
        check(vkBindBufferMemory(device_, buffer, memory.get(), 0), "vkBindBufferMemory");
        return memory;
      }
    throw Error(ErrorKind::device, "Vulkan: no memory type fits");
  }

  /// A command buffer whose next command sees what all commands before it have written.
  VkCommandBuffer record() {
    if (recording_ == VK_NULL_HANDLE) {
      if (pool_.get() == VK_NULL_HANDLE) {
        auto info = structure<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
        info.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
        info.queueFamilyIndex = family_;
        pool_ = CommandPool::make(device_, vkCreateCommandPool, info, "vkCreateCommandPool");
      }
      auto info = structure<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
      info.commandPool = pool_.get();
      info.commandBufferCount = 1;
      VkCommandBuffer commands = VK_NULL_HANDLE;
      check(vkAllocateCommandBuffers(device_, &info, &commands), "vkAllocateCommandBuffers");
      used_.push_back(commands);
      auto begin = structure<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
      begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
      check(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer");
      recording_ = commands;
    }
    barrier(VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT,
            VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_READ_BIT |
                VK_ACCESS_TRANSFER_WRITE_BIT);
    return recording_;
  }

  /// Lets the host see what the commands recorded so far have written, once they have run.
  void release_to_host() { barrier(VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT); }

  /// Starts what was recorded.
  VkResult submit() {
    if (recording_ == VK_NULL_HANDLE) return VK_SUCCESS;
    const VkCommandBuffer commands = std::exchange(recording_, VK_NULL_HANDLE);
    if (const VkResult result = vkEndCommandBuffer(commands); result != VK_SUCCESS) return result;
    auto info = structure<VkSubmitInfo>(VK_STRUCTURE_TYPE_SUBMIT_INFO);
    info.commandBufferCount = 1;
    info.pCommandBuffers = &commands;
    return vkQueueSubmit(queue_, 1, &info, VK_NULL_HANDLE);
  }

  /// Submits and waits for everything.
  VkResult finish() {
    const VkResult submitted = submit();
    const VkResult waited = vkQueueWaitIdle(queue_);
    if (!used_.empty())
      vkFreeCommandBuffers(device_, pool_.get(), static_cast<std::uint32_t>(used_.size()), used_.data());
    used_.clear();
    return submitted != VK_SUCCESS ? submitted : waited;
  }

 private:
  void barrier(VkPipelineStageFlags stages, VkAccessFlags access) {
    auto memory = structure<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
    memory.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
    memory.dstAccessMask = access;
    vkCmdPipelineBarrier(recording_, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT,
                         stages, 0, 1, &memory, 0, nullptr, 0, nullptr);
  }

  std::unique_ptr<Instance> instance_;
  VkPhysicalDevice physical_;
  std::uint32_t family_;
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  CommandPool pool_;
  VkCommandBuffer recording_ = VK_NULL_HANDLE;
  std::vector<VkCommandBuffer> used_;  // since the last finish()
};

/// A buffer in mapped memory and, unless that is what kernels use, a second one in the device's own memory.
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
  ~VulkanBuffer() override { session_->finish(); }  // after an exception the device may still be at work

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
      : session(std::move(session)), source(source), shape(shape), workgroup(workgroup) {}
  ~VulkanKernel() override { session->finish(); }
  std::shared_ptr<Session> session;
  const KernelSource& source;
  Shape shape;
  std::uint32_t workgroup;
  SetLayout set_layout;
  PipelineLayout layout;
  Pipeline pipeline;
};

/// A Vulkan 1.2 device with one queue. Uploads and clears are submitted with the next dispatch or download.
class VulkanDevice final : public Device {
 public:
  VulkanDevice(std::unique_ptr<Instance> instance, VkPhysicalDevice physical, std::size_t index,
               ZeroCopy zero_copy)
      : info_(describe(physical, index)) {
    if (zero_copy == ZeroCopy::never) info_.is_unified = false;
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(physical, &properties);
    max_groups_x_ = properties.limits.maxComputeWorkGroupCount[0];
    tick_seconds_ = properties.limits.timestampComputeAndGraphics == VK_TRUE
                        ? 1e-9 * static_cast<double>(properties.limits.timestampPeriod)
                        : 0;
    session_ = std::make_shared<Session>(std::move(instance), physical);

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
    const VkDevice device = session_->device();
    auto kernel = std::make_unique<VulkanKernel>(session_, source, shape, workgroup);

    std::vector<VkDescriptorSetLayoutBinding> bindings;
    for (std::uint32_t binding = 0; binding < source.buffers; ++binding)
      bindings.push_back(
          {binding, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
    auto set =
        structure<VkDescriptorSetLayoutCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO);
    set.bindingCount = source.buffers;
    set.pBindings = bindings.data();
    kernel->set_layout =
        SetLayout::make(device, vkCreateDescriptorSetLayout, set, "vkCreateDescriptorSetLayout");

    const VkDescriptorSetLayout set_layout = kernel->set_layout.get();
    const VkPushConstantRange range{VK_SHADER_STAGE_COMPUTE_BIT, 0, source.parameter_bytes};
    auto layout = structure<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
    layout.setLayoutCount = 1;
    layout.pSetLayouts = &set_layout;
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &range;
    kernel->layout = PipelineLayout::make(device, vkCreatePipelineLayout, layout, "vkCreatePipelineLayout");

    const std::span<const std::uint32_t> spirv = source.spirv[static_cast<int>(shape)];
    auto code = structure<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
    code.codeSize = spirv.size_bytes();
    code.pCode = spirv.data();
    const ShaderModule module =
        ShaderModule::make(device, vkCreateShaderModule, code, "vkCreateShaderModule");

    const VkSpecializationMapEntry entry{0, 0, sizeof workgroup};
    const VkSpecializationInfo specialization{1, &entry, sizeof workgroup, &workgroup};
    auto info = structure<VkComputePipelineCreateInfo>(VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO);
    info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    info.stage.module = module.get();
    info.stage.pName = "main";
    info.stage.pSpecializationInfo = &specialization;
    info.layout = kernel->layout.get();
    VkPipeline pipeline = VK_NULL_HANDLE;
    check(vkCreateComputePipelines(device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
          "vkCreateComputePipelines");
    kernel->pipeline = {device, pipeline};
    return kernel;
  }

  void dispatch(Kernel& kernel, std::span<Buffer* const> buffers, std::span<const std::byte> parameters,
                std::uint32_t units) override {
    auto& loaded = static_cast<VulkanKernel&>(kernel);
    check_dispatch(loaded.source, buffers.size(), parameters.size(), units);
    if (units == 0) return;
    if (dispatched_ == max_dispatches) wait();

    const VkDescriptorSet set = bind(loaded.set_layout.get(), buffers);
    const std::uint32_t groups =
        loaded.shape == Shape::group ? units : (units + loaded.workgroup - 1) / loaded.workgroup;
    const std::uint32_t groups_x =
        std::min(groups, max_groups_x_);  // the dialect's GROUP_INDEX is x + width * y
    const std::uint32_t groups_y = (groups + groups_x - 1) / groups_x;

    const VkCommandBuffer commands = session_->record();
    const std::uint32_t query = 2 * dispatched_++;
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, loaded.pipeline.get());
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, loaded.layout.get(), 0, 1, &set, 0,
                            nullptr);
    vkCmdPushConstants(commands, loaded.layout.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0,
                       static_cast<std::uint32_t>(parameters.size()), parameters.data());
    vkCmdResetQueryPool(commands, timestamps_.get(), query, 2);
    vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, timestamps_.get(), query);
    vkCmdDispatch(commands, groups_x, groups_y, 1);
    vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, timestamps_.get(), query + 1);
    check(session_->submit(), "vkQueueSubmit");
  }

  void wait() override {
    check(session_->finish(), "vkQueueWaitIdle");
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
    session_->instance().check_messages();
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
  try {
    const Instance instance;
    for (VkPhysicalDevice device : find_devices(instance.get(), notes))
      infos.push_back(describe(device, infos.size()));
  } catch (const Error& error) {
    notes.push_back(fmt::format("{}: install a driver such as mesa-vulkan-drivers", error.what()));
  }
  return infos;
}

std::unique_ptr<Device> open_vulkan(std::size_t index, ZeroCopy zero_copy) {
  auto instance = std::make_unique<Instance>();
  std::vector<std::string> notes;
  const VkPhysicalDevice physical = find_devices(instance->get(), notes).at(index);
  return std::make_unique<VulkanDevice>(std::move(instance), physical, index, zero_copy);
}

}  // namespace boxunion
