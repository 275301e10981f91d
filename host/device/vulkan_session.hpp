#pragma once

#include <vulkan/vulkan.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "host/device/backend.hpp"
#include "host/device/device.hpp"

// Instances, logical devices and commands of Vulkan. Internal to host/device/vulkan_*.cpp.
namespace boxunion::vulkan {

/// Throws Error(device), or Error(resources) for lack of memory, unless the call succeeded.
void check(VkResult result, const char* call);

inline DriverProcess process;

/// A Vulkan structure, zero except for its type.
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
    if (handle_ != VK_NULL_HANDLE && process.is_here()) destroy(device_, handle_, nullptr);
  }
  T get() const { return handle_; }

  /// Makes a new object. `create` is the vkCreate... or vkAllocate... function.
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
using Fence = Handle<VkFence, vkDestroyFence>;

/// A VkInstance. With BOXUNION_VULKAN_VALIDATION=1 it also collects the messages of the validation layer.
class Instance {
 public:
  Instance();
  ~Instance();
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;
  VkInstance get() const { return handle_; }

  /// Throws Error(device) with the first message since the last call, if there was one.
  void check_messages();

 private:
  static VKAPI_ATTR VkBool32 VKAPI_CALL receive(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                                VkDebugUtilsMessageTypeFlagsEXT,
                                                const VkDebugUtilsMessengerCallbackDataEXT* data, void* self);

  VkInstance handle_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  std::mutex mutex_;
  std::vector<std::string> messages_;
};

/// The instance of this process. It is never destroyed, because loading the drivers takes a fraction of a
/// second. Under validation, every caller gets its own instance, so that the layer notices leaks.
std::shared_ptr<Instance> shared_instance();

/// The devices that support the kernels' SPIR-V: Vulkan 1.2, 64-bit integers and a compute queue.
std::vector<VkPhysicalDevice> find_devices(VkInstance instance, std::vector<std::string>& notes);

/// A kernel in the form that a device runs.
struct Program {
  SetLayout set_layout;
  PipelineLayout layout;
  Pipeline pipeline;
};

/// A VkDevice with one queue, for any number of threads, and the programs made for it.
class LogicalDevice {
 public:
  LogicalDevice(std::shared_ptr<Instance> instance, VkPhysicalDevice physical);
  ~LogicalDevice();
  LogicalDevice(const LogicalDevice&) = delete;
  LogicalDevice& operator=(const LogicalDevice&) = delete;

  VkDevice get() const { return device_; }
  VkPhysicalDevice physical() const { return physical_; }
  std::uint32_t family() const { return family_; }
  Instance& instance() const { return *instance_; }
  /// True if nothing works any more.
  bool is_lost() const { return lost_; }

  /// Appends commands to the queue, if any are given. The fence, if one is given, signals that they have run.
  VkResult submit(VkCommandBuffer commands, VkFence fence);
  VkResult wait(VkFence fence);
  /// The program of a kernel. It is made at the first call.
  const Program& program(const KernelSource& source, Shape shape, std::uint32_t workgroup);

 private:
  VkResult noted(VkResult result);

  std::shared_ptr<Instance> instance_;
  VkPhysicalDevice physical_;
  std::uint32_t family_;
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  std::atomic<bool> lost_ = false;
  std::mutex queue_mutex_, program_mutex_;
  std::map<std::tuple<std::string_view, Shape, std::uint32_t>, Program> programs_;
};

/// The logical device of a physical one, the index-th of find_devices(). It is kept for the whole process,
/// because a program takes a tenth of a second to make, and a process may open a device many times. Under
/// validation, it is kept only while it is used.
std::shared_ptr<LogicalDevice> logical_device(std::size_t index);

/// The state that an open device, its buffers and its kernels share, so that they may be destroyed in any
/// order: the commands that are being recorded or run.
class Session {
 public:
  explicit Session(std::shared_ptr<LogicalDevice> logical);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  LogicalDevice& logical() { return *logical_; }
  VkDevice device() const { return logical_->get(); }

  /// Memory of a type that has all `required` flags and, if there is such a type, also the `preferred` ones.
  Memory allocate(VkBuffer buffer, VkMemoryPropertyFlags required, VkMemoryPropertyFlags preferred);
  /// A command buffer whose next command sees everything that earlier commands have written.
  VkCommandBuffer record();
  /// Lets the host see what the commands recorded so far write, once they have run.
  void release_to_host();
  /// Starts the recorded commands.
  VkResult submit();
  /// Submits and waits for everything. After a fork, it only returns that the device is lost.
  VkResult finish();

 private:
  void barrier(VkPipelineStageFlags stages, VkAccessFlags access);

  std::shared_ptr<LogicalDevice> logical_;
  CommandPool pool_;
  Fence finished_;
  VkCommandBuffer recording_ = VK_NULL_HANDLE;
  std::vector<VkCommandBuffer> used_;  // since the last finish()
};

}  // namespace boxunion::vulkan
