#!/usr/bin/env python3
"""isometric.py vertices.csv > picture.svg: draws a union of boxes with small integer coordinates.

It knows nothing of the boxes: the faces come from the vertices and octant masks that `boxunion boundary` wrote.
docs/pictures/make draws all pictures of the documents.
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


def outlines(triangles):
    """Closed polygons around some triangles of the grid: the sides that only one triangle has, with collinear sides joined."""
    after = defaultdict(set)
    for p, q, r in triangles:
        if (q[0] - p[0]) * (r[1] - p[1]) < (q[1] - p[1]) * (r[0] - p[0]):
            q, r = r, q
        for side in (p, q), (q, r), (r, p):
            if side[0] in after[side[1]]:
                after[side[1]].remove(side[0])
            else:
                after[side[0]].add(side[1])
    for start in sorted(after):
        while after[start]:
            loop = [start]
            while len(loop) == 1 or loop[-1] != start:
                loop.append(after[loop[-1]].pop())
            loop.pop()
            yield [
                p
                for o, p, q in zip(loop[-1:] + loop, loop, loop[1:] + loop[:1])
                if (p[0] - o[0]) * (q[1] - p[1]) != (p[1] - o[1]) * (q[0] - p[0])
            ]


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

    regions = defaultdict(list)  # what is seen of each plane
    for _, axis, corner, triangle in front.values():
        regions[axis, corner[axis]].append([project(p) for p in triangle])
    paths = [[], [], []]
    for (axis, _), parts in sorted(regions.items()):
        for loop in outlines(parts):
            steps = [(q[0] - p[0], q[1] - p[1]) for p, q in zip(loop, loop[1:])]
            paths[axis].append("M%d %dl" % loop[0] + " ".join("%d %d" % step for step in steps) + "z")

    corners = [project(p) for p, _ in vertices]
    left, right = min(c[0] for c in corners) - 1, max(c[0] for c in corners) + 1
    top, bottom = min(c[1] for c in corners) - 1, max(c[1] for c in corners) + 1
    width, height = (right - left) * 1.732, bottom - top
    print('<svg xmlns="http://www.w3.org/2000/svg" viewBox="%.1f %.1f %.1f %.1f" width="360" height="%.0f">'
          % (left * 1.732, top, width, height, 360 * height / width))
    print('<g transform="scale(1.732 1)" fill-rule="evenodd" stroke="#0b2530" stroke-width=".1" stroke-linejoin="round">')
    for shade, path in zip(SHADES, paths):
        print('<path fill="%s" d="%s"/>' % (shade, "\n".join(path)))
    print("</g>\n</svg>")


if __name__ == "__main__":
    main(sys.argv[1])
