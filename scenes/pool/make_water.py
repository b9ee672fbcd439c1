#!/usr/bin/env python3
"""Write water.ply, the surface of the pool: a sum of sine waves on a square grid, as a binary triangle mesh.

    python3 make_water.py

The sheet is HALF wide on either side of the origin in x and z, at y = 0 on average, with exact vertex normals that
point up. Needs nothing but Python's standard library.
"""

import math
import struct

HALF = 1.6  # half the side of the sheet, in scene units; the basin is 1.5, so the rim hides the edge
CELLS = 60  # along one side
# Each wave: direction in degrees, wavelength, amplitude, phase. Together they focus sunlight about one basin deep.
WAVES = [
    (12, 0.83, 0.0170, 0.4),
    (71, 0.62, 0.0104, 2.1),
    (118, 0.71, 0.0120, 4.4),
    (161, 0.47, 0.0054, 1.3),
    (38, 0.39, 0.0036, 5.2),
    (95, 0.53, 0.0060, 3.7),
]


def surface(x, z):
    """Height at (x, z) and the unit normal there."""
    height = slope_x = slope_z = 0.0
    for degrees, wavelength, amplitude, phase in WAVES:
        k = 2 * math.pi / wavelength
        kx, kz = k * math.cos(math.radians(degrees)), k * math.sin(math.radians(degrees))
        angle = kx * x + kz * z + phase
        height += amplitude * math.sin(angle)
        slope_x += amplitude * kx * math.cos(angle)
        slope_z += amplitude * kz * math.cos(angle)
    length = math.sqrt(slope_x**2 + 1 + slope_z**2)
    return height, (-slope_x / length, 1 / length, -slope_z / length)


def main():
    side = CELLS + 1
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {side * side}",
        *(f"property float {name}" for name in ("x", "y", "z", "nx", "ny", "nz")),
        f"element face {2 * CELLS * CELLS}",
        "property list uchar int vertex_indices",
        "end_header\n",
    ]
    with open("water.ply", "wb") as out:
        out.write("\n".join(header).encode("ascii"))
        for j in range(side):
            for i in range(side):
                x, z = (2 * i / CELLS - 1) * HALF, (2 * j / CELLS - 1) * HALF
                height, normal = surface(x, z)
                out.write(struct.pack("<6f", x, height, z, *normal))
        for j in range(CELLS):
            for i in range(CELLS):
                a = j * side + i
                b, c, d = a + 1, a + side, a + side + 1
                # Counter-clockwise from above.
                out.write(struct.pack("<B3i", 3, a, c, b))
                out.write(struct.pack("<B3i", 3, b, c, d))


if __name__ == "__main__":
    main()
