#pragma once

/// All public headers: boxes from memory, files, volumes or generators, boolean expressions over them, mass
/// properties, boundaries and disjoint boxes on any device, components, and files.

#include "boxunion/array.hpp"
#include "boxunion/axis.hpp"
#include "boxunion/box.hpp"
#include "boxunion/brep.hpp"
#include "boxunion/components.hpp"
#include "boxunion/contour.hpp"
#include "boxunion/decomposition.hpp"
#include "boxunion/device.hpp"
#include "boxunion/error.hpp"
#include "boxunion/evm.hpp"
#include "boxunion/export.hpp"
#include "boxunion/expression.hpp"
#include "boxunion/external.hpp"
#include "boxunion/files.hpp"
#include "boxunion/generate.hpp"
#include "boxunion/mass.hpp"
#include "boxunion/mesh.hpp"
#include "boxunion/octants.hpp"
#include "boxunion/rectangle.hpp"
#include "boxunion/solid.hpp"
#include "boxunion/statistics.hpp"
#include "boxunion/union.hpp"
#include "boxunion/volume.hpp"
#include "boxunion/voxels.hpp"
