#pragma once

/// Everything that boxunion offers to programs: boxes from memory, files, volumes or generators, boolean
/// expressions over them, mass properties, boundary and disjoint boxes on any device, components, and files.

#include "core/adjacency.hpp"
#include "core/axis.hpp"
#include "core/box.hpp"
#include "core/brep.hpp"
#include "core/components.hpp"
#include "core/decomposition.hpp"
#include "core/error.hpp"
#include "core/evm.hpp"
#include "core/expression.hpp"
#include "core/generate.hpp"
#include "core/generate_volume.hpp"
#include "core/mass.hpp"
#include "core/octants.hpp"
#include "core/solid.hpp"
#include "core/triangulation.hpp"
#include "core/vertex.hpp"
#include "core/volume.hpp"
#include "core/voxel_boxes.hpp"
#include "core/voxel_labels.hpp"
#include "host/boundary.hpp"
#include "host/device.hpp"
#include "host/engine.hpp"
#include "host/files.hpp"
#include "host/volume.hpp"
