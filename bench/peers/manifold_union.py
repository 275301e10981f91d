#!/usr/bin/env python3
"""manifold_union.py boxes.csv|boxes.npy: seconds that Manifold (pip install manifold3d) takes for the same union.

Prints volume and area, to be compared with `boxunion measure`, and the seconds of making the boxes, of the batch union
and of its properties. The times of boxunion to compare with are its `total`: from boxes in memory to the result.
"""
import sys
import time

import numpy
from manifold3d import Manifold, OpType


def main(path):
    boxes = numpy.load(path) if path.endswith(".npy") else numpy.loadtxt(path, delimiter=",", skiprows=1)
    boxes = boxes.astype(float)
    start = time.perf_counter()
    solids = [Manifold.cube(b[3:] - b[:3]).translate(b[:3]) for b in boxes if (b[3:] > b[:3]).all()]
    made = time.perf_counter()
    union = Manifold.batch_boolean(solids, OpType.Add)
    volume, area = union.volume(), union.surface_area()
    done = time.perf_counter()
    print(f"volume {volume!r} area {area!r} triangles {union.num_tri()}")
    print(f"seconds: boxes {made - start:.3f} union {done - made:.3f}")


main(sys.argv[1])
