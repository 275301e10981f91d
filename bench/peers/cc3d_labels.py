#!/usr/bin/env python3
"""cc3d_labels.py BOXUNION VOLUME.npy [RUNS]: seconds that cc3d (pip install connected-components-3d) takes to label a
volume of uint8, beside those of `boxunion label`, in turn, for both connectivities.

Both are from the volume in memory to labels in memory. The labels of both are compared first: they must be the same
but for the order of their numbers.
"""
import json
import statistics
import subprocess
import sys
import tempfile
import time

import cc3d
import numpy


def same_partition(a, b):
    """Do the labels map one to one, 0 to 0?"""
    pairs = numpy.unique(a.astype(numpy.uint64) << numpy.uint64(32) | b)
    first, second = pairs >> numpy.uint64(32), pairs & numpy.uint64(0xFFFFFFFF)
    return all(len(numpy.unique(side)) == len(pairs) for side in (first, second)) and (first == 0).tolist() == (
        second == 0
    ).tolist()


def in_order(labels):
    """Are the labels numbered from 1 in the order of their first voxels?"""
    values, first = numpy.unique(labels, return_index=True)
    first = first[values != 0]
    return (values[values != 0] == numpy.arange(1, len(first) + 1)).all() and (numpy.diff(first) > 0).all()


def main(command, path, runs=5):
    volume = numpy.load(path)
    for connectivity in (6, 26):
        ours, theirs = [], []
        with tempfile.NamedTemporaryFile(suffix=".npy") as output:
            arguments = [command, "label", path, "--connectivity", str(connectivity), "--json"]
            subprocess.run(arguments + ["-o", output.name], check=True, stdout=subprocess.DEVNULL)
            labels = numpy.load(output.name)
            expected = cc3d.connected_components(volume, connectivity=connectivity)
            assert same_partition(labels, expected) and in_order(labels), "the labels differ"
            count = int(expected.max())
            del labels, expected
        for _ in range(int(runs)):
            ours.append(json.loads(subprocess.run(arguments, check=True, capture_output=True).stdout)["seconds"]["total"])
            start = time.perf_counter()
            cc3d.connected_components(volume, connectivity=connectivity, binary_image=True)
            theirs.append(time.perf_counter() - start)
        a, b = statistics.median(ours), statistics.median(theirs)
        print(f"connectivity {connectivity}: {count} components, boxunion {a:.3f} s, cc3d {b:.3f} s, ratio {b / a:.2f}")
        print("  boxunion", " ".join(f"{t:.3f}" for t in ours), "  cc3d", " ".join(f"{t:.3f}" for t in theirs))


main(*sys.argv[1:])
