#!/usr/bin/env python3
"""scipy_volume.py BOXUNION VOLUME [THRESHOLD]: checks what boxunion says of a volume (.npy, .tif) with NumPy and SciPy.

Volume, area, extreme vertices and components of both connectivities, from the voxels (pip install numpy scipy
tifffile). Prints both sides; exits with 1 where they differ.
"""
import json
import subprocess
import sys

import numpy
import scipy.ndimage


def read(path):
    if path.endswith(".npy"):
        return numpy.load(path)
    import tifffile

    return tifffile.imread(path)


def area(inside):
    """Faces between a voxel inside and one outside."""
    padded = numpy.pad(inside, 1).astype(numpy.int8)
    return sum(int(numpy.abs(numpy.diff(padded, axis=axis)).sum()) for axis in range(3))


def extreme_vertices(inside):
    """Points with an odd number of voxels inside round them."""
    odd = numpy.pad(inside, 1)
    for axis in range(3):
        low, high = [slice(None)] * 3, [slice(None)] * 3
        low[axis], high[axis] = slice(None, -1), slice(1, None)
        odd = odd[tuple(low)] ^ odd[tuple(high)]
    return int(odd.sum())


def components(inside, full):
    return scipy.ndimage.label(inside, scipy.ndimage.generate_binary_structure(3, 3 if full else 1))[1]


def main(command, path, threshold=None):
    volume = read(path)
    inside = volume != 0 if threshold is None else volume >= float(threshold)
    options = [path, "--json"] + ([] if threshold is None else ["--threshold", threshold])

    def ask(*words):
        return json.loads(subprocess.run([command, *words, *options], check=True, capture_output=True).stdout)

    mass = ask("measure")
    found = {
        "volume": mass["volume"],
        "area": mass["area"],
        "extreme vertices": mass["extreme_vertices"],
        "components (6)": ask("label", "--connectivity", "6")["components"],
        "components (26)": ask("label", "--connectivity", "26")["components"],
    }
    expected = dict(
        zip(
            found,
            (int(inside.sum()), area(inside), extreme_vertices(inside), components(inside, False), components(inside, True)),
        )
    )
    for what, value in found.items():
        print(f"{what:16} boxunion {value:14}  voxels {expected[what]:14}")
    sys.exit(found != expected)


main(*sys.argv[1:])
