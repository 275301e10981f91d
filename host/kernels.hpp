#pragma once

#include "host/device.hpp"

namespace boxunion::kernels {

const KernelSource& contour();

}  // namespace boxunion::kernels
