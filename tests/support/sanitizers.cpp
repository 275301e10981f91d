// What the sanitizers must not blame on us. Linked into everything that is sanitized.
//
// Drivers keep memory until the process ends, some in modules that are unloaded before leaks are looked for,
// so that no suppression can name them: leaks are looked for only where ASAN_OPTIONS asks for it, which the
// tests without drivers do. lib3mf, with which tests read models back, leaks some of what libzip allocates. A
// thread that is just beginning when the process ends is asked for its stack by oneTBB and by the sanitizer
// itself, and what the C library allocates for that counts as leaked. Nothing is printed of what is
// suppressed: tests compare what the command prints.
//
// oneTBB, of which the command and the tests still use arenas, and the drivers (PoCL, lavapipe) were not
// built with the thread sanitizer and synchronise in ways that it cannot see.

extern "C" {
const char* __asan_default_options();
const char* __lsan_default_suppressions();
const char* __tsan_default_suppressions();

const char* __asan_default_options() {
  return "detect_leaks=0:print_suppressions=0";
}
const char* __lsan_default_suppressions() {
  return "leak:libzip.so\n"
         "leak:pthread_getattr_np\n"
         "leak:pthread_attr_\n";
}
const char* __tsan_default_suppressions() {
  return "race_top:oneapi/tbb/\n"
         "called_from_lib:libtbb.so\n"
         "called_from_lib:libpocl.so\n"
         "called_from_lib:libpocl-devices-basic.so\n"
         "called_from_lib:libpocl-devices-pthread.so\n"
         "called_from_lib:libvulkan_lvp.so\n";
}
}
