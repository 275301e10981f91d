#!/usr/bin/env python3
"""moocore_hypervolume.py FILE: the volume of boxes with a common upper corner, by moocore."""

import importlib.metadata
import sys

import moocore
import numpy
from contender import contend, read_boxes


def main(path):
    boxes = read_boxes(path)
    points = numpy.ascontiguousarray(boxes[:, :3])
    corner = boxes[0, 3:]
    contend(
        "moocore " + importlib.metadata.version("moocore"),
        lambda: moocore.hypervolume(points, ref=corner),
        lambda volume: {"volume": float(volume)},
    )


main(*sys.argv[1:])
