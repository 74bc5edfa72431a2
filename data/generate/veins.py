#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""veins.py out.png: makes data/veins.png, veined marble that repeats in both directions.

Ridges of periodic gradient noise, bent by more of it. Needs nothing but Python's own library; the
same bytes on every machine whose zlib compresses alike. About 3 seconds.

Source: Perlin 1985, "An Image Synthesizer" (noise, turbulence).
"""
import math
import random
import struct
import sys
import zlib

SIZE = 384  # pixels along an edge
SEED = 5


def gradient_noise(cells, rng):
    """Noise on the unit torus with `cells` x `cells` random gradients; about -0.7 to 0.7."""
    angles = [[rng.random() * 2 * math.pi for _ in range(cells)] for _ in range(cells)]
    gradients = [[(math.cos(a), math.sin(a)) for a in row] for row in angles]

    def noise(u, v):
        x, y = u * cells, v * cells
        i, j = math.floor(x), math.floor(y)
        fx, fy = x - i, y - j
        wx = fx * fx * fx * (fx * (6 * fx - 15) + 10)
        wy = fy * fy * fy * (fy * (6 * fy - 15) + 10)

        def corner(di, dj):
            g = gradients[(j + dj) % cells][(i + di) % cells]
            return g[0] * (fx - di) + g[1] * (fy - dj)

        low = corner(0, 0) + wx * (corner(1, 0) - corner(0, 0))
        high = corner(0, 1) + wx * (corner(1, 1) - corner(0, 1))
        return low + wy * (high - low)

    return noise


def marble(rng):
    """Colour of the stone at (u, v), sRGB from 0 to 1."""
    bend = [gradient_noise(c, rng) for c in (3, 3, 8, 8)]
    clouds = [gradient_noise(c, rng) for c in (3, 7, 19)]
    # Veins: cells across the picture, width, darkness.
    veins = [(gradient_noise(c, rng), width, depth)
             for c, width, depth in ((3, 0.03, 1.6), (5, 0.02, 0.9), (8, 0.025, 0.15))]
    stone, vein = (0.98, 0.965, 0.94), (0.22, 0.25, 0.28)

    def colour(u, v):
        bu = u + 0.11 * bend[0](u, v) + 0.035 * bend[2](u, v)
        bv = v + 0.11 * bend[1](u, v) + 0.035 * bend[3](u, v)
        cloud = sum(n(bu, bv) / 2 ** k for k, n in enumerate(clouds))
        dark = 0.10 * max(0.0, 0.3 + cloud)
        for noise, width, depth in veins:
            ridge = noise(bu, bv)
            strength = 0.55 + 0.9 * cloud  # veins come and go
            dark += depth * max(0.0, min(1.0, strength)) * math.exp(-(ridge / width) ** 2)
        dark = 1 - math.exp(-dark)
        return [a + dark * (b - a) for a, b in zip(stone, vein)]

    return colour


def chunk(kind, data):
    return (struct.pack(">I", len(data)) + kind + data +
            struct.pack(">I", zlib.crc32(kind + data)))


def write_png(path, rows):
    """8-bit sRGB; each row is predicted by the one above (filter 2), which suits smooth pictures."""
    data, above = bytearray(), bytes(3 * SIZE)
    for row in rows:
        data.append(2)
        data += bytes((a - b) & 255 for a, b in zip(row, above))
        above = row
    header = struct.pack(">IIBBBBB", SIZE, SIZE, 8, 2, 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"sRGB", b"\0") +
                   chunk(b"IDAT", zlib.compress(bytes(data), 9)) + chunk(b"IEND", b""))


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: veins.py out.png")
    colour = marble(random.Random(SEED))
    rows = [bytes(round(255 * c) for x in range(SIZE)
                  for c in colour((x + 0.5) / SIZE, (y + 0.5) / SIZE)) for y in range(SIZE)]
    write_png(sys.argv[1], rows)


if __name__ == "__main__":
    main()
