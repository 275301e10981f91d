// What the sanitizers must ignore. Linked into everything that is sanitized.
//
// Drivers keep memory until the process ends. Some of it belongs to modules that are unloaded before leaks
// are looked for, so no suppression can name it. Leaks are therefore looked for only if ASAN_OPTIONS asks for
// it, as the tests without drivers do. lib3mf, with which tests read models back, leaks some memory that
// libzip allocates. If a thread is just starting when the process ends, oneTBB and the sanitizer itself ask
// for its stack, and the memory that the C library allocates for that counts as leaked. Suppressions print
// nothing, because tests compare the output of the command.
//
// oneTBB, whose arenas the command and the tests still use, and the drivers (PoCL, lavapipe) were not built
// with the thread sanitizer. They synchronise in ways that it cannot see.

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
