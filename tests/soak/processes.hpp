#pragma once

#include <functional>

namespace boxunion::soak {

/// Runs f in a process of its own, so that what it starts and allocates is gone afterwards. Throws
/// std::runtime_error where that fails. Not where this process has threads.
void run_in_child(const std::function<void()>& f);

}  // namespace boxunion::soak
