#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""cup.py out.ply: makes data/cup.ply, a cup without a handle, 40 mm tall, its wall 3 mm thick.

Closed, 2-manifold, oriented outward, hollow, so that much of the light that leaves it meets it
again; flat triangles of about 1 mm. It stands on y = 0 around the y axis. Needs nothing but
Python's own library.
"""
import math
import struct
import sys

SPOKES = 96
STEP = 1.1  # mm along the outline
HEIGHT, FLOOR = 40.0, 5.0  # mm
OUTER_FOOT, OUTER_RIM = 11.0, 17.0  # radii, mm
WALL_FOOT, WALL_RIM = 3.4, 2.6  # thickness, mm


def outline():
    """Corners of half a section, (radius, y) in mm, from the axis below to the axis inside."""
    rim = [(OUTER_RIM - WALL_RIM / 2 * (1 - math.cos(a)), HEIGHT + WALL_RIM / 2 * (math.sin(a) - 1))
           for a in (math.pi * k / 8 for k in range(9))]
    inside = OUTER_FOOT - WALL_FOOT
    return [(0.0, 0.0), (OUTER_FOOT - 1, 0.0), (OUTER_FOOT, 1.0), *rim, (inside + 0.8, FLOOR + 1.6),
            (inside - 0.6, FLOOR), (0.0, FLOOR)]


def divided(corners):
    """The same line with points about STEP apart."""
    points = [corners[0]]
    for (r0, y0), (r1, y1) in zip(corners, corners[1:]):
        parts = max(1, round(math.hypot(r1 - r0, y1 - y0) / STEP))
        points += [(r0 + (r1 - r0) * k / parts, y0 + (y1 - y0) * k / parts)
                   for k in range(1, parts + 1)]
    return points


def mesh():
    """Vertices and triangles of the line turned around the y axis; its ends are single points."""
    line = divided(outline())
    last = len(line) - 2  # of the rings
    vertices = [(0.0, line[0][1], 0.0)]
    for radius, y in line[1:-1]:
        vertices += [(radius * math.cos(a), y, radius * math.sin(a))
                     for a in (2 * math.pi * k / SPOKES for k in range(SPOKES))]
    vertices.append((0.0, line[-1][1], 0.0))

    def at(ring, spoke):
        return 1 + (ring - 1) * SPOKES + spoke % SPOKES

    triangles = []
    for spoke in range(SPOKES):
        triangles.append((0, at(1, spoke), at(1, spoke + 1)))
        for ring in range(1, last):
            a, b = at(ring, spoke), at(ring, spoke + 1)
            c, d = at(ring + 1, spoke), at(ring + 1, spoke + 1)
            triangles += [(a, c, b), (b, c, d)]
        triangles.append((at(last, spoke), len(vertices) - 1, at(last, spoke + 1)))
    return vertices, triangles


def main():
    vertices, triangles = mesh()
    header = ("ply\nformat binary_little_endian 1.0\ncomment tallow data/generate/cup.py\n"
              f"element vertex {len(vertices)}\nproperty float x\nproperty float y\n"
              f"property float z\nelement face {len(triangles)}\n"
              "property list uchar int vertex_indices\nend_header\n")
    with open(sys.argv[1], "wb") as file:
        file.write(header.encode())
        for v in vertices:
            file.write(struct.pack("<3f", *v))
        for t in triangles:
            file.write(struct.pack("<B3i", 3, *t))
    print(f"{len(vertices)} vertices, {len(triangles)} triangles")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main()
