#pragma once

/// Everything that boxunion offers to programs: boxes from memory, files or generators, their union, its mass
/// properties, its boundary and disjoint boxes on any device, and their files.

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
#include "core/mass.hpp"
#include "core/octants.hpp"
#include "core/solid.hpp"
#include "core/triangulation.hpp"
#include "core/vertex.hpp"
#include "host/boundary.hpp"
#include "host/device.hpp"
#include "host/engine.hpp"
#include "host/files.hpp"
