#!/usr/bin/env python3
"""cc3d_labels.py CONNECTIVITY FILE.npy: connected components of a volume of uint8 by cc3d."""

import importlib.metadata
import sys

import cc3d
import numpy
from contender import contend


def checksum(labels):
    """The sum of label * (2 * index + 1) modulo 2^64, of labels renumbered in the order of their first voxels."""
    values, first, inverse = numpy.unique(labels.ravel(), return_index=True, return_inverse=True)
    order = numpy.argsort(numpy.where(values == 0, -1, first))
    number = numpy.empty(len(values), numpy.uint64)
    number[order] = numpy.arange(len(values)) + (values[order[0]] != 0)
    weights = 2 * numpy.arange(labels.size, dtype=numpy.uint64) + numpy.uint64(1)
    return int((number[inverse.ravel()] * weights).sum(dtype=numpy.uint64))


def main(connectivity, path):
    volume = numpy.load(path)

    def compute():
        return cc3d.connected_components(volume, connectivity=int(connectivity), binary_image=True)

    def describe(labels):
        return {"components": int(labels.max()), "checksum": checksum(labels)}

    contend("cc3d " + importlib.metadata.version("connected-components-3d"), compute, describe)


main(*sys.argv[1:])
