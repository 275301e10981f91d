#pragma once

#include "host/device/device.hpp"

/// The kernels of kernels/*.k, embedded at build time. There is one declaration for each kernel in
/// cmake/Kernels.cmake, which generates the definitions.
namespace boxunion::kernels {

const KernelSource& contour();
const KernelSource& cell_faces();           ///< vertices
const KernelSource& cell_occupancy();       ///< vertices
const KernelSource& cell_occupancy_sums();  ///< integer sums
const KernelSource& cell_boolean();         ///< vertices; cells may have programs
const KernelSource& cell_boolean_sums();    ///< integer sums; cells may have programs
const KernelSource& copy();                 ///< copies an array: the bandwidth of a device's memory

}  // namespace boxunion::kernels
