// Open CASCADE: the union of boxes by one fuse of all of them, in parallel, and faces and edges that continue
// each other unified.
//
//   peer_occt_fuse FILE

#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepGProp.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <GProp_GProps.hxx>
#include <Standard_Failure.hxx>
#include <Standard_Version.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopTools_ListOfShape.hxx>

#include "bench/peers/contender.hpp"
#include "host/files/files.hpp"

namespace {

TopoDS_Shape unite(const boxunion::BoxSet& boxes) try {
  TopTools_ListOfShape first, others;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const boxunion::Box b = boxes[i];
    (i == 0 ? first : others)
        .Append(BRepPrimAPI_MakeBox(gp_Pnt(b[0], b[1], b[2]), gp_Pnt(b[3], b[4], b[5])).Shape());
  }
  BRepAlgoAPI_Fuse fuse;
  fuse.SetArguments(first);
  fuse.SetTools(others);
  fuse.SetRunParallel(true);
  fuse.SetUseOBB(true);
  fuse.Build();
  if (fuse.HasErrors()) throw std::runtime_error("the fuse failed");
  fuse.SimplifyResult();
  return fuse.Shape();
} catch (const Standard_Failure& e) {
  throw std::runtime_error(std::string("the fuse failed: ") + e.GetMessageString());
}

nlohmann::json describe(const TopoDS_Shape& shape) {
  const auto count = [&](TopAbs_ShapeEnum kind) {
    TopTools_IndexedMapOfShape all;
    TopExp::MapShapes(shape, kind, all);
    return all.Extent();
  };
  GProp_GProps volume, area;
  BRepGProp::VolumeProperties(shape, volume);
  BRepGProp::SurfaceProperties(shape, area);
  return {{"volume", volume.Mass()},
          {"area", area.Mass()},
          {"vertices", count(TopAbs_VERTEX)},
          {"edges", count(TopAbs_EDGE)},
          {"faces", count(TopAbs_FACE)}};
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) throw std::runtime_error("expected FILE");
  const boxunion::BoxSet boxes = boxunion::read_boxes(argv[1]);
  boxunion::peers::contend(
      "Open CASCADE " OCC_VERSION_COMPLETE " BRepAlgoAPI_Fuse", [&] { return unite(boxes); }, describe);
  return 0;
} catch (const std::exception& e) {
  std::cerr << e.what() << '\n';
  return 1;
}
