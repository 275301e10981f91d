#!/usr/bin/env python3
"""trimesh_union.py FILE: the union of boxes by trimesh, which calls Manifold. Making the boxes is not timed."""

import sys

import trimesh
from contender import contend, read_boxes


def main(path):
    boxes = [trimesh.creation.box(bounds=(b[:3], b[3:])) for b in read_boxes(path)]

    def compute():
        union = trimesh.boolean.union(boxes, engine="manifold", check_volume=False)
        return union, union.volume, union.area

    def describe(result):
        union, volume, area = result
        return {"volume": float(volume), "area": float(area), "triangles": len(union.faces)}

    contend("trimesh " + trimesh.__version__, compute, describe)


main(*sys.argv[1:])
