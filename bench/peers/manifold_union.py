#!/usr/bin/env python3
"""manifold_union.py FILE: the union of boxes by Manifold, in one batch. Making the boxes is not timed."""

import importlib.metadata
import sys

from contender import contend, read_boxes
from manifold3d import Manifold, OpType


def main(path):
    boxes = read_boxes(path)

    def make():
        solids = [Manifold.cube(b[3:] - b[:3]).translate(b[:3]) for b in boxes]
        for solid in solids:
            solid.volume()  # or their transforms would be left to the union
        return solids

    def compute():
        union = Manifold.batch_boolean(solids, OpType.Add)
        return union, union.volume(), union.surface_area()

    def describe(result):
        union, volume, area = result
        return {"volume": volume, "area": area, "triangles": union.num_tri()}

    solids = make()
    contend("Manifold " + importlib.metadata.version("manifold3d"), compute, describe)


main(*sys.argv[1:])
