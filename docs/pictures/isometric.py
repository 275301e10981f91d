#!/usr/bin/env python3
"""isometric.py vertices.csv > picture.svg: draws a union of boxes with small integer coordinates.

It knows nothing of the boxes: the faces come from the vertices and octant masks that `boxunion boundary` wrote.
The picture of README.md:
  boxunion generate sponge --level 3 -o sponge.npy
  boxunion boundary sponge.npy -o vertices.csv
  docs/pictures/isometric.py vertices.csv > docs/pictures/sponge.svg
"""
import csv
import sys
from collections import defaultdict
from itertools import product

SHADES = ("#3a7ca5", "#16425b", "#d9dcd6")  # of faces towards +x, +y, +z


def face_squares(vertices):
    """Unit squares of the faces towards +x, +y, +z, as (axis, low corner).

    In the plane of such faces the exposed area is the double prefix sum of its corners' weights, and every corner
    of it is a vertex of the union.
    """
    weights = defaultdict(int)
    for point, mask in vertices:
        for axis in range(3):
            u, v = 1 << (axis + 1) % 3, 1 << (axis + 2) % 3
            below = (0, u, v, u | v)
            exposed = [mask >> k & 1 and not mask >> (k | 1 << axis) & 1 for k in below]
            weights[axis, point] += exposed[0] - exposed[1] - exposed[2] + exposed[3]
    size = [max(point[a] for point, _ in vertices) + 1 for a in range(3)]
    low = [min(point[a] for point, _ in vertices) for a in range(3)]
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for h in range(low[axis], size[axis]):
            row = defaultdict(int)  # sums over the rows so far
            for j in range(low[v], size[v]):
                inside = 0
                for i in range(low[u], size[u]):
                    corner = [0, 0, 0]
                    corner[axis], corner[u], corner[v] = h, i, j
                    row[i] += weights.get((axis, tuple(corner)), 0)
                    inside += row[i]
                    if inside:
                        yield axis, tuple(corner)


def triangles(axis, corner):
    """The two triangles of a square: corners in space, split so that all squares share one triangular grid."""
    u, v = (axis + 1) % 3, (axis + 2) % 3

    def at(i, j):
        p = list(corner)
        p[u] += i
        p[v] += j
        return tuple(p)

    return (at(0, 0), at(1, 0), at(1, 1)), (at(0, 0), at(0, 1), at(1, 1))


def project(p):
    return p[0] - p[1], p[0] + p[1] - 2 * p[2]


def main(path):
    with open(path, newline="") as file:
        vertices = [(tuple(int(row[a]) for a in "xyz"), int(row["mask"])) for row in csv.DictReader(file)]
    front = {}  # the foremost square at each triangle of the grid
    for axis, corner in face_squares(vertices):
        for triangle in triangles(axis, corner):
            key = frozenset(map(project, triangle))
            depth = sum(map(sum, triangle))
            if depth > front.get(key, (-1,))[0]:
                front[key] = depth, axis, corner, triangle

    seen = defaultdict(list)
    for _, axis, corner, triangle in front.values():
        seen[axis, corner].append(triangle)
    paths = [[], [], []]
    for (axis, _), parts in sorted(seen.items()):
        if len(parts) == 2:
            (a, b, c), (_, d, _) = parts
            outline = [a, b, c, d]
        else:
            outline = parts[0]
        points = [project(p) for p in outline]
        steps = [(q[0] - p[0], q[1] - p[1]) for p, q in zip(points, points[1:])]
        paths[axis].append("M%d %dl" % points[0] + " ".join("%d %d" % s for s in steps) + "z")

    corners = [project(p) for p, _ in vertices]
    left, right = min(c[0] for c in corners) - 1, max(c[0] for c in corners) + 1
    top, bottom = min(c[1] for c in corners) - 1, max(c[1] for c in corners) + 1
    width, height = (right - left) * 1.732, bottom - top
    print('<svg xmlns="http://www.w3.org/2000/svg" viewBox="%.1f %.1f %.1f %.1f" width="360" height="%.0f">'
          % (left * 1.732, top, width, height, 360 * height / width))
    print('<g transform="scale(1.732 1)" stroke-width=".05">')
    for shade, path in zip(SHADES, paths):
        print('<path fill="%s" stroke="%s" d="%s"/>' % (shade, shade, "\n".join(path)))
    print("</g>\n</svg>")


if __name__ == "__main__":
    main(sys.argv[1])
