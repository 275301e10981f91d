#pragma once

// The texts below the options in `boxunion --help` and `boxunion SUBCOMMAND --help`.

namespace boxunion::command {

inline constexpr const char* kExamples = R"(
Examples:
  boxunion generate cubes --count 1000000 --edge 48 -o cubes.npy
  boxunion measure cubes.npy
  boxunion measure --json --device native - < boxes.csv
  boxunion boundary boxes.csv -o vertices.csv
  boxunion boundary boxes.csv -o boxes.3mf
  boxunion decompose boxes.csv --order best -o disjoint.csv
  boxunion label boxes.csv -o labelled.npy
  boxunion combine "A and B not C" A=a.csv B=b.npy C=c.csv
  boxunion boundary scan.tif --threshold 90 -o scan.stl
  boxunion label scan.nrrd --connectivity 26 -o labels.npy --components components.csv
  boxunion bench --quick

Boxes are read from .csv (lines xmin,ymin,zmin,xmax,ymax,zmax with an optional header) or .npy (an array of
shape (n, 6) of float64, float32, int32 or int64). Volumes of voxels are read from {}
(.npy: an array of shape (z, y, x)). Each voxel inside is a box.
Whole numbers may have an exponent (1e6). Sizes may have a unit (512M, 1.5G, 2GiB).

Exit status: 0 done, 2 wrong usage, 3 bad input, 4 device missing or failed, 5 out of memory, disk or limits,
130 interrupted.)";

inline constexpr const char* kExpressions = R"(
Operations, tightest first. Operations of equal rank go from left to right:
  A and B   A & B   in both
  A not B   A - B   in A but not in B; also "A minus B", "A and not B"
  A xor B   A ^ B   in exactly one of them
  A or B    A | B   in at least one of them
Names consist of letters, digits and _. Each set stands for the union of its boxes. Parts of the result without
thickness are left out. The method slices and the kernel faces find unions only.

Examples:
  boxunion combine "A not B" A=block.csv B=holes.npy --json
  boxunion combine "metal and (via1 or via2) not cut" metal=m.npy via1=a.npy via2=b.npy cut=c.csv -o out.stl)";

inline constexpr const char* kBench = R"(
Every case is checked against the native device and then timed. Device time is the time of the kernel as the
device measures it, or CPU time on the native device. Wall time is from the batch in host memory to the result in
host memory. The first run includes the time to compile the kernel, unless the driver or this process has compiled
it before. Spreads are half the distance between the quartiles. Rates are per second of device time. "of copy" is
the fraction of the bandwidth of a copy on that device.

BOXUNION_TUNING names the tuning file in use; if it is empty, none is used. If it is not set,
$XDG_CONFIG_HOME/boxunion/tuning.json or ~/.config/boxunion/tuning.json is read.

Examples:
  boxunion bench --quick
  boxunion bench --device opencl,vulkan --kernel contour --shape item --workgroup 8,16,32 --json new.json
  boxunion bench --compare old.json new.json
  boxunion bench --tune)";

}  // namespace boxunion::command
