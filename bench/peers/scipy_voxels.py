#!/usr/bin/env python3
"""scipy_voxels.py FILE.npy: volume, area, extreme vertices and components of a volume's voxels by NumPy and SciPy."""

import sys

import numpy
import scipy.ndimage
from contender import contend


def area(inside):
    """Faces between a voxel inside and one outside."""
    padded = numpy.pad(inside, 1).astype(numpy.int8)
    return sum(int(numpy.abs(numpy.diff(padded, axis=axis)).sum(dtype=numpy.int64)) for axis in range(3))


def extreme_vertices(inside):
    """Points with an odd number of inside voxels around them."""
    odd = numpy.pad(inside, 1)
    for axis in range(3):
        low, high = [slice(None)] * 3, [slice(None)] * 3
        low[axis], high[axis] = slice(None, -1), slice(1, None)
        odd = odd[tuple(low)] ^ odd[tuple(high)]
    return int(odd.sum())


def components(inside, full):
    return scipy.ndimage.label(inside, scipy.ndimage.generate_binary_structure(3, 3 if full else 1))[1]


def main(path):
    inside = numpy.load(path) != 0

    def compute():
        return {
            "volume": int(inside.sum()),
            "area": area(inside),
            "extreme_vertices": extreme_vertices(inside),
            "components_6": components(inside, False),
            "components_26": components(inside, True),
        }

    contend("SciPy " + scipy.__version__, compute, lambda answer: answer)


main(*sys.argv[1:])
