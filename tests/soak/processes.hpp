#pragma once

#include <functional>

namespace boxunion::soak {

/// Runs f in a process of its own, so that everything that f starts and allocates is gone afterwards. Throws
/// std::runtime_error if that fails. Not for a process with threads.
void run_in_child(const std::function<void()>& f);

}  // namespace boxunion::soak
