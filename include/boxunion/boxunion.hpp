#pragma once

/// Everything that boxunion offers to programs: boxes from memory, files, volumes or generators, their union,
/// its mass properties and its boundary on any device, components of volumes, and files of vertices and
/// meshes.

#include "core/axis.hpp"
#include "core/box.hpp"
#include "core/brep.hpp"
#include "core/error.hpp"
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
