#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/memory.hpp"
#include "core/boundary/planes.hpp"
#include "core/boundary/points.hpp"
#include "core/solid/solid.hpp"

namespace boxunion {

struct Faces;

/// The shells of a boundary and what they enclose.
///
/// A shell joins faces across edges; at a non-manifold edge it joins those that bound the same filled sector.
/// So it belongs to one body, a component of the solid's interior (pieces that share a face). One shell of a
/// body encloses it; the others are its cavities. Shells are numbered by their lowest vertices, bodies by
/// their outer shells'.
struct Shells {
  Array<std::uint32_t> of_face;      ///< the shell of every face
  std::vector<std::uint32_t> body;   ///< of every shell
  std::vector<std::uint8_t> cavity;  ///< is the shell a cavity?
  std::size_t bodies = 0;

  std::size_t size() const { return body.size(); }
  std::size_t cavities() const { return size() - bodies; }
};

/// The shells of the faces that find_faces found. Near-linear; where there are both several bodies and
/// cavities, the walls towards -x take O(sqrt(cavities)) each besides.
Shells find_shells(const Solid& solid, const Planes& planes, const Faces& faces, NonManifold contacts);

}  // namespace boxunion
