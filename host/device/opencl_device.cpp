#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <utility>

#include "boxunion/error.hpp"
#include "host/device/backend.hpp"

namespace boxunion {
namespace {

DriverProcess process;
/// Drivers may fail if several threads load them at once.
std::mutex waking;

/// Releases an OpenCL handle; the driver keeps what queued commands still use.
template <auto release>
struct Release {
  template <class T>
  void operator()(T* handle) const {
    if (process.is_here()) release(handle);
  }
};
using Context = std::unique_ptr<_cl_context, Release<clReleaseContext>>;
using Queue = std::unique_ptr<_cl_command_queue, Release<clReleaseCommandQueue>>;
using Program = std::unique_ptr<_cl_program, Release<clReleaseProgram>>;
using KernelHandle = std::unique_ptr<_cl_kernel, Release<clReleaseKernel>>;
using Memory = std::unique_ptr<_cl_mem, Release<clReleaseMemObject>>;
using Event = std::unique_ptr<_cl_event, Release<clReleaseEvent>>;

const char* error_name(cl_int status) {
  switch (status) {
    case CL_DEVICE_NOT_AVAILABLE:
      return "device not available";
    case CL_MEM_OBJECT_ALLOCATION_FAILURE:
      return "memory object allocation failure";
    case CL_OUT_OF_RESOURCES:
      return "out of resources";
    case CL_OUT_OF_HOST_MEMORY:
      return "out of host memory";
    case CL_BUILD_PROGRAM_FAILURE:
      return "build program failure";
    case CL_INVALID_WORK_GROUP_SIZE:
      return "invalid work group size";
    case CL_INVALID_BUFFER_SIZE:
      return "invalid buffer size";
    case CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST:
      return "a command failed";
    default:
      return "error";
  }
}

void check(cl_int status, const char* call) {
  if (status == CL_SUCCESS) return;
  const bool memory = status == CL_MEM_OBJECT_ALLOCATION_FAILURE || status == CL_OUT_OF_RESOURCES ||
                      status == CL_OUT_OF_HOST_MEMORY;
  throw Error(memory ? ErrorKind::resources : ErrorKind::device,
              fmt::format("OpenCL: {}: {} ({})", call, error_name(status), status));
}

template <class T>
T property(cl_device_id device, cl_device_info what) {
  T value{};
  check(clGetDeviceInfo(device, what, sizeof value, &value, nullptr), "clGetDeviceInfo");
  return value;
}

std::string text(cl_device_id device, cl_device_info what) {
  std::size_t size = 0;
  check(clGetDeviceInfo(device, what, 0, nullptr, &size), "clGetDeviceInfo");
  std::string value(size, '\0');
  check(clGetDeviceInfo(device, what, size, value.data(), nullptr), "clGetDeviceInfo");
  return value.c_str();  // without trailing zeros
}

/// Every device of every platform that can build programs.
std::vector<cl_device_id> find_devices(std::vector<std::string>& notes) {
  if (!process.claim()) {
    notes.push_back(used_before_fork("OpenCL"));
    return {};
  }
  const std::lock_guard lock(waking);
  cl_uint count = 0;
  if (clGetPlatformIDs(0, nullptr, &count) != CL_SUCCESS || count == 0) {
    notes.emplace_back("OpenCL: no platform found: install a driver such as pocl-opencl-icd");
    return {};
  }
  std::vector<cl_platform_id> platforms(count);
  check(clGetPlatformIDs(count, platforms.data(), nullptr), "clGetPlatformIDs");
  std::vector<cl_device_id> devices;
  for (cl_platform_id platform : platforms) {
    if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &count) != CL_SUCCESS) continue;
    std::vector<cl_device_id> found(count);
    check(clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, count, found.data(), nullptr), "clGetDeviceIDs");
    for (cl_device_id device : found)
      if (property<cl_bool>(device, CL_DEVICE_AVAILABLE) != 0 &&
          property<cl_bool>(device, CL_DEVICE_COMPILER_AVAILABLE) != 0)
        devices.push_back(device);
  }
  if (devices.empty()) notes.emplace_back("OpenCL: the platforms found have no usable device");
  return devices;
}

DeviceInfo describe(cl_device_id device, std::size_t index) {
  DeviceInfo info;
  info.id = fmt::format("opencl:{}", index);
  info.name = text(device, CL_DEVICE_NAME);
  info.driver = text(device, CL_DEVICE_VERSION) + ", " + text(device, CL_DRIVER_VERSION);
  info.is_cpu = (property<cl_device_type>(device, CL_DEVICE_TYPE) & CL_DEVICE_TYPE_CPU) != 0;
  info.is_unified = info.is_cpu || property<cl_bool>(device, CL_DEVICE_HOST_UNIFIED_MEMORY) != 0;
  info.max_buffer_bytes = property<cl_ulong>(device, CL_DEVICE_MAX_MEM_ALLOC_SIZE);
  info.max_workgroup =
      static_cast<std::uint32_t>(property<std::size_t>(device, CL_DEVICE_MAX_WORK_GROUP_SIZE));
  info.memory_bytes = property<cl_ulong>(device, CL_DEVICE_GLOBAL_MEM_SIZE);
  // On a CPU, a barrier splits the kernel into loops over the work-items, so one work-item per unit is
  // fastest, and the size of a group matters little. A GPU needs lanes that do the same thing.
  info.preferred_shape = info.is_cpu ? Shape::item : Shape::group;
  info.preferred_workgroup = std::min(info.is_cpu ? 8u : 64u, info.max_workgroup);
  return info;
}

/// A context and the programs built in it. It is kept for the whole process, because a program takes up to a
/// second to build, and a process may open a device many times.
struct SharedContext {
  Context context;
  std::mutex mutex;
  std::map<std::string, Program> programs;  // by options and name
};

SharedContext& shared_context(cl_device_id device) {
  // never destroyed: drivers may be unloaded before static objects are destroyed
  static auto& contexts = *new std::map<cl_device_id, std::unique_ptr<SharedContext>>;
  const std::lock_guard lock(waking);
  std::unique_ptr<SharedContext>& shared = contexts[device];
  if (!shared) {
    cl_int status = CL_SUCCESS;
    Context context(clCreateContext(nullptr, 1, &device, nullptr, nullptr, &status));
    check(status, "clCreateContext");
    shared = std::make_unique<SharedContext>();
    shared->context = std::move(context);
  }
  return *shared;
}

std::string build_log(cl_program program, cl_device_id device) {
  std::size_t size = 0;
  clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, 0, nullptr, &size);
  std::string log(size, '\0');
  clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, size, log.data(), nullptr);
  return log.c_str();
}

Program build(cl_context context, cl_device_id device, const KernelSource& source,
              const std::string& options) {
  const char* code = source.opencl.data();
  const std::size_t length = source.opencl.size();
  cl_int status = CL_SUCCESS;
  Program program(clCreateProgramWithSource(context, 1, &code, &length, &status));
  check(status, "clCreateProgramWithSource");
  status = clBuildProgram(program.get(), 1, &device, options.c_str(), nullptr, nullptr);
  if (status != CL_SUCCESS)
    throw Error(ErrorKind::device, fmt::format("OpenCL: kernel {} does not build ({}): {}", source.name,
                                               status, build_log(program.get(), device)));
  return program;
}

class OpenclBuffer;

/// The state that a device and its buffers share, so that they may be destroyed in any order.
struct Session {
  SharedContext& shared;
  Queue queue;
  std::vector<OpenclBuffer*> lent;  // zero-copy buffers that the device owns until the next wait()
};

class OpenclBuffer final : public Buffer {
 public:
  OpenclBuffer(std::shared_ptr<Session> session, std::size_t bytes, bool zero_copy)
      : session_(std::move(session)), pages_(allocate_pages(bytes)), zero_copy_(zero_copy) {
    cl_int status = CL_SUCCESS;
    const std::size_t whole = round_up(bytes, page_bytes);
    const cl_mem_flags flags = CL_MEM_READ_WRITE | (zero_copy ? cl_mem_flags{CL_MEM_USE_HOST_PTR} : 0u);
    memory_.reset(clCreateBuffer(session_->shared.context.get(), flags, whole,
                                 zero_copy ? pages_.get() : nullptr, &status));
    check(status, "clCreateBuffer");
    host_ = pages_.get();
    bytes_ = bytes;
    if (zero_copy) {
      map();
      check(clFinish(session_->queue.get()), "clFinish");
    }
  }
  ~OpenclBuffer() override {
    // after an exception, the device may still be working
    if (process.is_here()) clFinish(session_->queue.get());
    std::erase(session_->lent, this);
  }

  /// The handle for a command. The host has no access from now until the next wait().
  cl_mem lend() {
    if (zero_copy_ && mapped_) {
      check(clEnqueueUnmapMemObject(session_->queue.get(), memory_.get(), host_, 0, nullptr, nullptr),
            "clEnqueueUnmapMemObject");
      mapped_ = false;
      session_->lent.push_back(this);
    }
    return memory_.get();
  }
  /// Returns access to the host, once the queue has reached this point.
  void map() {
    cl_int status = CL_SUCCESS;
    clEnqueueMapBuffer(session_->queue.get(), memory_.get(), CL_FALSE, CL_MAP_READ | CL_MAP_WRITE, 0,
                       round_up(bytes_, page_bytes), 0, nullptr, nullptr, &status);
    check(status, "clEnqueueMapBuffer");
    mapped_ = true;
  }
  std::byte* host() { return static_cast<std::byte*>(host_); }
  bool zero_copy() const { return zero_copy_; }

 private:
  std::shared_ptr<Session> session_;
  Pages pages_;
  Memory memory_;
  bool zero_copy_;
  bool mapped_ = false;
};

struct OpenclKernel final : Kernel {
  OpenclKernel(const KernelSource& source, Shape shape, std::uint32_t workgroup)
      : source(source), shape(shape), workgroup(workgroup) {}
  const KernelSource& source;
  Shape shape;
  std::uint32_t workgroup;
  KernelHandle handle;
};

/// An OpenCL 1.2 device with one in-order queue.
class OpenclDevice final : public Device {
 public:
  OpenclDevice(cl_device_id device, std::size_t index, ZeroCopy zero_copy)
      : device_(device), info_(describe(device, index)) {
    if (zero_copy == ZeroCopy::never) info_.is_unified = false;
    SharedContext& shared = shared_context(device);
    cl_int status = CL_SUCCESS;
    Queue queue(clCreateCommandQueue(shared.context.get(), device, CL_QUEUE_PROFILING_ENABLE, &status));
    check(status, "clCreateCommandQueue");
    session_.reset(new Session{shared, std::move(queue), {}});
  }
  ~OpenclDevice() override {
    if (process.is_here()) clFinish(queue());
  }

  const DeviceInfo& info() const override { return info_; }

  std::unique_ptr<Buffer> allocate(std::size_t bytes) override {
    check_allocation(info_, bytes);
    return std::make_unique<OpenclBuffer>(session_, bytes, info_.is_unified);
  }

  void upload(Buffer& buffer, std::size_t bytes) override {
    auto& target = static_cast<OpenclBuffer&>(buffer);
    const cl_mem memory = target.lend();
    if (target.zero_copy() || bytes == 0) return;
    check(clEnqueueWriteBuffer(queue(), memory, CL_FALSE, 0, bytes, target.host(), 0, nullptr, nullptr),
          "clEnqueueWriteBuffer");
  }

  void download(Buffer& buffer, std::size_t offset, std::size_t bytes) override {
    auto& source = static_cast<OpenclBuffer&>(buffer);
    const cl_mem memory = source.lend();
    if (!source.zero_copy() && bytes != 0)
      check(clEnqueueReadBuffer(queue(), memory, CL_FALSE, offset, bytes, source.host() + offset, 0, nullptr,
                                nullptr),
            "clEnqueueReadBuffer");
    check(clFlush(queue()), "clFlush");
  }

  void clear(Buffer& buffer, std::size_t bytes) override {
    const cl_uint zero = 0;
    const cl_mem memory = static_cast<OpenclBuffer&>(buffer).lend();
    if (bytes == 0) return;
    check(clEnqueueFillBuffer(queue(), memory, &zero, sizeof zero, 0, round_up(bytes, sizeof zero), 0,
                              nullptr, nullptr),
          "clEnqueueFillBuffer");
  }

  std::unique_ptr<Kernel> load(const KernelSource& source, Shape shape, std::uint32_t workgroup) override {
    check_workgroup(info_, shape, workgroup);
    auto kernel = std::make_unique<OpenclKernel>(source, shape, workgroup);
    // PoCL 3.1 takes minutes to optimise the larger kernels for groups. When it vectorizes for AVX-512, the
    // last work-item of a group above 16 runs one turn of LANES too many. Groups on a CPU need not be fast.
    const bool mistrust = info_.is_cpu && shape == Shape::group;
    const std::string options =
        fmt::format("-cl-std=CL1.2{} -DWORKGROUP={}{} {}", mistrust ? " -cl-opt-disable" : "", workgroup,
                    shape == Shape::item ? " -DITEM" : "", source.opencl_options);
    SharedContext& shared = session_->shared;
    const std::lock_guard lock(shared.mutex);
    Program& program = shared.programs[options + " " + std::string(source.name)];
    if (!program) program = build(shared.context.get(), device_, source, options);
    cl_kernel handle = nullptr;
    check(clCreateKernelsInProgram(program.get(), 1, &handle, nullptr), "clCreateKernelsInProgram");
    kernel->handle.reset(handle);
    return kernel;
  }

  void dispatch(Kernel& kernel, std::span<Buffer* const> buffers, std::span<const std::byte> parameters,
                std::uint32_t units) override {
    auto& loaded = static_cast<OpenclKernel&>(kernel);
    check_dispatch(loaded.source, buffers.size(), parameters.size(), units);
    if (units == 0) return;
    const cl_kernel handle = loaded.handle.get();
    cl_uint argument = 0;
    for (Buffer* buffer : buffers) {
      const cl_mem memory = static_cast<OpenclBuffer*>(buffer)->lend();
      check(clSetKernelArg(handle, argument++, sizeof memory, &memory), "clSetKernelArg");
    }
    check(clSetKernelArg(handle, argument, parameters.size(), parameters.data()), "clSetKernelArg");
    const std::size_t local = loaded.workgroup;
    const std::size_t global = loaded.shape == Shape::group ? units * local : round_up(units, local);
    cl_event event = nullptr;
    check(clEnqueueNDRangeKernel(queue(), handle, 1, nullptr, &global, &local, 0, nullptr, &event),
          "clEnqueueNDRangeKernel");
    dispatched_.emplace_back(event);
    check(clFlush(queue()), "clFlush");
  }

  void wait() override {
    for (OpenclBuffer* buffer : session_->lent) buffer->map();
    session_->lent.clear();
    check(clFinish(queue()), "clFinish");
    for (const Event& event : std::exchange(dispatched_, {})) {
      cl_int status = CL_COMPLETE;
      check(clGetEventInfo(event.get(), CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof status, &status, nullptr),
            "clGetEventInfo");
      if (status < 0) check(status, "kernel");
      cl_ulong start = 0, end = 0;
      check(clGetEventProfilingInfo(event.get(), CL_PROFILING_COMMAND_START, sizeof start, &start, nullptr),
            "clGetEventProfilingInfo");
      check(clGetEventProfilingInfo(event.get(), CL_PROFILING_COMMAND_END, sizeof end, &end, nullptr),
            "clGetEventProfilingInfo");
      seconds_ += 1e-9 * static_cast<double>(end - start);
    }
  }

  double kernel_seconds() const override { return seconds_; }

 private:
  cl_command_queue queue() const { return session_->queue.get(); }

  cl_device_id device_;
  DeviceInfo info_;
  std::shared_ptr<Session> session_;
  std::vector<Event> dispatched_;  // since the last wait()
  double seconds_ = 0;
};

}  // namespace

std::vector<DeviceInfo> list_opencl(std::vector<std::string>& notes) {
  std::vector<DeviceInfo> devices;
  for (cl_device_id device : find_devices(notes)) devices.push_back(describe(device, devices.size()));
  return devices;
}

std::unique_ptr<Device> open_opencl(std::size_t index, ZeroCopy zero_copy) {
  std::vector<std::string> notes;
  const std::vector<cl_device_id> devices = find_devices(notes);
  if (index >= devices.size())
    throw Error(ErrorKind::device, notes.empty() ? "OpenCL: the device has disappeared" : notes.back());
  return std::make_unique<OpenclDevice>(devices[index], index, zero_copy);
}

}  // namespace boxunion
