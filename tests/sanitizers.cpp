// What the sanitizers must not blame on us: drivers keep memory until the process ends, and libraries that
// were not built with the thread sanitizer synchronise in ways that it cannot see. Linked into everything
// that is sanitized.

extern "C" {
const char* __lsan_default_suppressions();
const char* __tsan_default_suppressions();

const char* __lsan_default_suppressions() {
  return "leak:libpocl\nleak:libOpenCL\nleak:libLLVM\nleak:libvulkan\nleak:libhwloc\n";
}
const char* __tsan_default_suppressions() {
  return "called_from_lib:libtbb.so\ncalled_from_lib:libpocl.so\ncalled_from_lib:libvulkan_lvp.so\n"
         "race:tbb::detail\n";
}
}
