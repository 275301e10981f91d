#include "host/device/vulkan_session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>

#include "boxunion/error.hpp"
#include "host/device/backend.hpp"

namespace boxunion::vulkan {
namespace {

/// The first queue family that supports compute.
std::optional<std::uint32_t> compute_family(VkPhysicalDevice device) {
  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
  for (std::uint32_t family = 0; family < count; ++family)
    if ((families[family].queueFlags & VK_QUEUE_COMPUTE_BIT) != 0) return family;
  return std::nullopt;
}

bool is_validated() {
  return environment_flag("BOXUNION_VULKAN_VALIDATION");
}

Program make_program(VkDevice device, const KernelSource& source, Shape shape, std::uint32_t workgroup) {
  Program program;
  std::vector<VkDescriptorSetLayoutBinding> bindings;
  for (std::uint32_t binding = 0; binding < source.buffers; ++binding)
    bindings.push_back({binding, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
  auto set = structure<VkDescriptorSetLayoutCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO);
  set.bindingCount = source.buffers;
  set.pBindings = bindings.data();
  program.set_layout =
      SetLayout::make(device, vkCreateDescriptorSetLayout, set, "vkCreateDescriptorSetLayout");

  const VkDescriptorSetLayout set_layout = program.set_layout.get();
  const VkPushConstantRange range{VK_SHADER_STAGE_COMPUTE_BIT, 0, source.parameter_bytes};
  auto layout = structure<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
  layout.setLayoutCount = 1;
  layout.pSetLayouts = &set_layout;
  layout.pushConstantRangeCount = 1;
  layout.pPushConstantRanges = &range;
  program.layout = PipelineLayout::make(device, vkCreatePipelineLayout, layout, "vkCreatePipelineLayout");

  const std::span<const std::uint32_t> spirv = source.spirv[static_cast<int>(shape)];
  auto code = structure<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
  code.codeSize = spirv.size_bytes();
  code.pCode = spirv.data();
  const ShaderModule module = ShaderModule::make(device, vkCreateShaderModule, code, "vkCreateShaderModule");

  const VkSpecializationMapEntry entry{0, 0, sizeof workgroup};
  const VkSpecializationInfo specialization{1, &entry, sizeof workgroup, &workgroup};
  auto info = structure<VkComputePipelineCreateInfo>(VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO);
  info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module.get();
  info.stage.pName = "main";
  info.stage.pSpecializationInfo = &specialization;
  info.layout = program.layout.get();
  VkPipeline pipeline = VK_NULL_HANDLE;
  check(vkCreateComputePipelines(device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
        "vkCreateComputePipelines");
  program.pipeline = {device, pipeline};
  return program;
}

}  // namespace

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

Instance::Instance() {
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
  auto messenger =
      structure<VkDebugUtilsMessengerCreateInfoEXT>(VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT);
  messenger.messageSeverity =
      VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
  messenger.pfnUserCallback = &Instance::receive;
  messenger.pUserData = this;

  if (is_validated()) {
    create.enabledLayerCount = 1;
    create.ppEnabledLayerNames = &layer;
    create.enabledExtensionCount = 2;
    create.ppEnabledExtensionNames = extensions;
    create.pNext = &features;
  }
  check(vkCreateInstance(&create, nullptr, &handle_), "vkCreateInstance");
  if (is_validated()) {
    const auto make = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(handle_, "vkCreateDebugUtilsMessengerEXT"));
    make(handle_, &messenger, nullptr, &messenger_);
  }
}

Instance::~Instance() {
  if (!process.is_here()) return;
  if (messenger_ != VK_NULL_HANDLE) {
    const auto destroy = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(handle_, "vkDestroyDebugUtilsMessengerEXT"));
    destroy(handle_, messenger_, nullptr);
  }
  if (handle_ != VK_NULL_HANDLE) vkDestroyInstance(handle_, nullptr);
}

void Instance::check_messages() {
  const std::lock_guard lock(mutex_);
  if (messages_.empty()) return;
  const std::string first = std::exchange(messages_, {}).front();
  throw Error(ErrorKind::device, "Vulkan validation: " + first);
}

VkBool32 Instance::receive(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                           const VkDebugUtilsMessengerCallbackDataEXT* data, void* self) {
  auto& instance = *static_cast<Instance*>(self);
  const std::lock_guard lock(instance.mutex_);
  instance.messages_.emplace_back(data->pMessage);
  return VK_FALSE;
}

std::shared_ptr<Instance> shared_instance() {
  if (!process.claim()) throw Error(ErrorKind::device, used_before_fork("Vulkan"));
  if (is_validated()) return std::make_shared<Instance>();
  static std::mutex mutex;
  // never destroyed: drivers may be unloaded before static objects are destroyed
  static auto& shared = *new std::shared_ptr<Instance>;
  const std::lock_guard lock(mutex);
  if (!shared) shared = std::make_shared<Instance>();
  return shared;
}

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

LogicalDevice::LogicalDevice(std::shared_ptr<Instance> instance, VkPhysicalDevice physical)
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

LogicalDevice::~LogicalDevice() {
  programs_.clear();
  if (!process.is_here()) return;
  vkDestroyDevice(device_, nullptr);
}

VkResult LogicalDevice::submit(VkCommandBuffer commands, VkFence fence) {
  auto info = structure<VkSubmitInfo>(VK_STRUCTURE_TYPE_SUBMIT_INFO);
  info.commandBufferCount = commands != VK_NULL_HANDLE ? 1 : 0;
  info.pCommandBuffers = &commands;
  const std::lock_guard lock(queue_mutex_);
  return noted(vkQueueSubmit(queue_, 1, &info, fence));
}

VkResult LogicalDevice::wait(VkFence fence) {
  const VkResult result =
      noted(vkWaitForFences(device_, 1, &fence, VK_TRUE, std::numeric_limits<std::uint64_t>::max()));
  return result != VK_SUCCESS ? result : vkResetFences(device_, 1, &fence);
}

VkResult LogicalDevice::noted(VkResult result) {
  if (result == VK_ERROR_DEVICE_LOST) lost_ = true;
  return result;
}

const Program& LogicalDevice::program(const KernelSource& source, Shape shape, std::uint32_t workgroup) {
  const std::lock_guard lock(program_mutex_);
  Program& program = programs_[{source.name, shape, workgroup}];
  if (program.pipeline.get() == VK_NULL_HANDLE) program = make_program(device_, source, shape, workgroup);
  return program;
}

std::shared_ptr<LogicalDevice> logical_device(std::size_t index) {
  const std::shared_ptr<Instance> instance = shared_instance();
  std::vector<std::string> notes;
  const VkPhysicalDevice physical = find_devices(instance->get(), notes).at(index);
  const auto make = [&] { return std::make_shared<LogicalDevice>(instance, physical); };
  if (is_validated()) return make();
  static std::mutex mutex;
  static auto& shared = *new std::map<VkPhysicalDevice, std::shared_ptr<LogicalDevice>>;  // never destroyed
  const std::lock_guard lock(mutex);
  std::shared_ptr<LogicalDevice>& logical = shared[physical];
  if (!logical || logical->is_lost()) logical = make();
  return logical;
}

Session::Session(std::shared_ptr<LogicalDevice> logical) : logical_(std::move(logical)) {
  auto pool = structure<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
  pool.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
  pool.queueFamilyIndex = logical_->family();
  pool_ = CommandPool::make(device(), vkCreateCommandPool, pool, "vkCreateCommandPool");
  const auto fence = structure<VkFenceCreateInfo>(VK_STRUCTURE_TYPE_FENCE_CREATE_INFO);
  finished_ = Fence::make(device(), vkCreateFence, fence, "vkCreateFence");
}

Memory Session::allocate(VkBuffer buffer, VkMemoryPropertyFlags required, VkMemoryPropertyFlags preferred) {
  VkMemoryRequirements requirements;
  vkGetBufferMemoryRequirements(device(), buffer, &requirements);
  VkPhysicalDeviceMemoryProperties properties;
  vkGetPhysicalDeviceMemoryProperties(logical_->physical(), &properties);
  for (const VkMemoryPropertyFlags wanted : {required | preferred, required})
    for (std::uint32_t type = 0; type < properties.memoryTypeCount; ++type) {
      if ((requirements.memoryTypeBits >> type & 1u) == 0) continue;
      if ((properties.memoryTypes[type].propertyFlags & wanted) != wanted) continue;
      auto info = structure<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
      info.allocationSize = requirements.size;
      info.memoryTypeIndex = type;
      Memory memory = Memory::make(device(), vkAllocateMemory, info, "vkAllocateMemory");
      check(vkBindBufferMemory(device(), buffer, memory.get(), 0), "vkBindBufferMemory");
      return memory;
    }
  throw Error(ErrorKind::device, "Vulkan: no memory type fits");
}

VkCommandBuffer Session::record() {
  if (recording_ == VK_NULL_HANDLE) {
    auto info = structure<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
    info.commandPool = pool_.get();
    info.commandBufferCount = 1;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    check(vkAllocateCommandBuffers(device(), &info, &commands), "vkAllocateCommandBuffers");
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

void Session::release_to_host() {
  barrier(VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT);
}

void Session::barrier(VkPipelineStageFlags stages, VkAccessFlags access) {
  auto memory = structure<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
  memory.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
  memory.dstAccessMask = access;
  vkCmdPipelineBarrier(recording_, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT,
                       stages, 0, 1, &memory, 0, nullptr, 0, nullptr);
}

VkResult Session::submit() {
  if (recording_ == VK_NULL_HANDLE) return VK_SUCCESS;
  const VkCommandBuffer commands = std::exchange(recording_, VK_NULL_HANDLE);
  const VkResult ended = vkEndCommandBuffer(commands);
  return ended != VK_SUCCESS ? ended : logical_->submit(commands, VK_NULL_HANDLE);
}

VkResult Session::finish() {
  if (!process.is_here()) return VK_ERROR_DEVICE_LOST;
  const VkResult submitted = submit();
  if (used_.empty()) return submitted;
  VkResult waited = logical_->submit(VK_NULL_HANDLE, finished_.get());
  if (waited == VK_SUCCESS) waited = logical_->wait(finished_.get());
  vkFreeCommandBuffers(device(), pool_.get(), static_cast<std::uint32_t>(used_.size()), used_.data());
  used_.clear();
  return submitted != VK_SUCCESS ? submitted : waited;
}

}  // namespace boxunion::vulkan
