#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""leaf.py out.ply: makes data/leaf.ply, a wavy leaf about 2 mm thick and 34 mm tall.

Closed, 2-manifold, oriented outward; flat triangles of 0.3 to 1 mm. It stands in the xy plane, its
foot at y = 0, and is the thin thing of the standard cases of experiments/. Needs nothing but
Python's own library.
"""
import math
import struct
import sys

RINGS, SPOKES = 26, 128
HEIGHT, WIDTH, THICKNESS = 34.0, 22.0, 2.0  # mm


def outline(angle):
    """Rim of the leaf around its middle, mm: an ellipse that comes to a point at the top."""
    x, y = math.sin(angle), math.cos(angle)
    tip = 1 + 0.12 * max(0.0, y) ** 8
    return WIDTH / 2 * x * (1 - 0.25 * y), HEIGHT / 2 * y * tip


def middle(x, y):
    """Height of the middle surface over the plane, mm: bent along its length, wavy across."""
    return 0.012 * y * y + 0.9 * math.sin(0.32 * y + 0.4) * (x / (WIDTH / 2)) ** 2


def thickness(rho, x, y):
    """Full thickness, mm, 0 at the rim; a midrib and six pairs of side veins are thicker."""
    body = THICKNESS * math.sqrt(max(0.0, 1 - rho ** 4))
    veins = 0.7 * math.exp(-((x / 0.9) ** 2))
    veins += 0.25 * math.exp(-((math.sin(0.62 * (y - 0.7 * abs(x))) / 0.35) ** 2))
    return body * (1 + veins * (1 - rho ** 2))


def vertex(ring, spoke, side):
    rho = math.sin(0.5 * math.pi * ring / RINGS)  # rings crowd where the rim curves
    x, y = (rho * c for c in outline(2 * math.pi * spoke / SPOKES))
    return x, y, middle(x, y) + side * thickness(rho, x, y) / 2


def mesh():
    """Vertices and triangles: the two sides share the rim."""
    vertices, index = [], {}

    def at(ring, spoke, side):
        key = (ring, spoke % SPOKES if ring else 0, side if ring < RINGS else 0)
        if key not in index:
            index[key] = len(vertices)
            vertices.append(vertex(key[0], key[1], key[2]))
        return index[key]

    triangles = []
    for side in (1, -1):
        for ring in range(RINGS):
            for spoke in range(SPOKES):
                inner = at(ring, spoke, side), at(ring, spoke + 1, side)
                outer = at(ring + 1, spoke, side), at(ring + 1, spoke + 1, side)
                faces = [(inner[0], outer[1], outer[0])]
                if ring:
                    faces.append((inner[0], inner[1], outer[1]))
                triangles += [f if side < 0 else f[::-1] for f in faces]
    foot = min(v[1] for v in vertices)
    return [(x, y - foot, z) for x, y, z in vertices], triangles


def main():
    vertices, triangles = mesh()
    header = ("ply\nformat binary_little_endian 1.0\ncomment tallow data/generate/leaf.py\n"
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
