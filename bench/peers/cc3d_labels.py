#!/usr/bin/env python3
"""cc3d_labels.py CONNECTIVITY FILE.npy: connected components of a volume of uint8 by cc3d."""

import importlib.metadata
import sys

import cc3d
import numpy
from contender import contend


def checksum(labels):
    """The sum of label * (2 * index + 1) modulo 2^64, for labels renumbered in the order of their first voxels."""
    flat = labels.ravel()
    count = int(flat.max())
    first = numpy.zeros(count + 1, numpy.int64)
    first[flat[::-1]] = numpy.arange(flat.size)[::-1]  # of equal labels the last one to be written stays
    number = numpy.zeros(count + 1, numpy.uint64)
    number[1:][numpy.argsort(first[1:])] = numpy.arange(1, count + 1)
    total = 0
    for start in range(0, flat.size, 1 << 24):
        part = number[flat[start : start + (1 << 24)]]
        weights = 2 * numpy.arange(start, start + part.size, dtype=numpy.uint64) + numpy.uint64(1)
        total += int((part * weights).sum(dtype=numpy.uint64))
    return total % 2**64


def main(connectivity, path):
    volume = numpy.load(path)

    def compute():
        return cc3d.connected_components(volume, connectivity=int(connectivity), binary_image=True)

    def describe(labels):
        return {"components": int(labels.max()), "checksum": checksum(labels)}

    contend("cc3d " + importlib.metadata.version("connected-components-3d"), compute, describe)


main(*sys.argv[1:])
