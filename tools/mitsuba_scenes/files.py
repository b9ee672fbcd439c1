"""Pictures and meshes that the small scenes refer to."""

import struct
import zlib

import mitsuba as mi
import numpy as np

# A twisted octahedron: corners without symmetry, so that a mesh that is mirrored or turned is seen.
CORNERS = [(1, 0.1, 0), (-0.9, 0.2, 0.1), (0.2, 0.8, -0.1), (0, -1.1, 0.2), (0.1, 0.1, 1.2), (-0.1, 0, -0.8)]
COORDINATES = [(0, 0.1), (0.9, 0.2), (0.4, 1), (0.6, 0), (0.5, 0.5), (1, 0.9)]
FACES = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]


def write_image(path, pixels, raw=False):
    """Numbers from 0 to 1 as 8-bit values, as they are."""
    bitmap = mi.Bitmap(np.round(255 * np.clip(pixels, 0, 1)).astype(np.uint8))
    bitmap.set_srgb_gamma(not raw)
    bitmap.write(str(path))


def write_floats(path, pixels):
    mi.Bitmap(pixels.astype(np.float32)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float16, False).write(str(path))


def heights(side):
    """A wavy surface from 0 to 1 that repeats at its edges."""
    v, u = (np.mgrid[0:side, 0:side] + 0.5) * (2 * np.pi / side)
    return 0.5 + 0.25 * np.sin(2 * u + np.cos(v)) + 0.25 * np.cos(3 * v)


def normals(height, steepness):
    down, right = np.gradient(height)
    vectors = np.stack([-steepness * right, steepness * down, np.ones_like(height)], axis=-1)
    return 0.5 + 0.5 * vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def write_meshes(folder):
    lines = [f"v {x} {y} {z}" for x, y, z in CORNERS] + [f"vt {u} {v}" for u, v in COORDINATES]
    lines += ["f " + " ".join(f"{corner + 1}/{corner + 1}" for corner in face) for face in FACES]
    (folder / "gem.obj").write_text("\n".join(lines) + "\n")
    names = "".join(f"property float {name}\n" for name in ["x", "y", "z", "u", "v"])
    header = f"ply\nformat ascii 1.0\nelement vertex {len(CORNERS)}\n{names}element face {len(FACES)}\n"
    rows = [" ".join(map(str, corner + uv)) for corner, uv in zip(CORNERS, COORDINATES)]
    rows += [" ".join(map(str, (3, *face))) for face in FACES]
    (folder / "gem.ply").write_text(header + "property list uchar int vertex_indices\nend_header\n" + "\n".join(rows) + "\n")


def write_smooth_meshes(folder):
    """The same with normals that are not those of its triangles."""
    unit = [np.array(corner) / np.linalg.norm(corner) for corner in CORNERS]
    normals = [" ".join(f"{value:.4f}" for value in normal) for normal in unit]
    lines = [f"v {x} {y} {z}" for x, y, z in CORNERS] + [f"vn {normal}" for normal in normals]
    lines += [f"vt {u} {v}" for u, v in COORDINATES]
    lines += ["f " + " ".join(f"{corner + 1}/{corner + 1}/{corner + 1}" for corner in face) for face in FACES]
    (folder / "smooth.obj").write_text("\n".join(lines) + "\n")
    names = "".join(f"property float {name}\n" for name in ["x", "y", "z", "nx", "ny", "nz", "u", "v"])
    header = f"ply\nformat ascii 1.0\nelement vertex {len(CORNERS)}\n{names}element face {len(FACES)}\n"
    rows = [f"{x} {y} {z} {normal} {u} {v}" for (x, y, z), normal, (u, v) in zip(CORNERS, normals, COORDINATES)]
    rows += [" ".join(map(str, (3, *face))) for face in FACES]
    (folder / "smooth.ply").write_text(header + "property list uchar int vertex_indices\nend_header\n" + "\n".join(rows) + "\n")


def write_serialized(path):
    """The mesh twice, upright and lying, in version 4 of the serialized format: single precision, with texture coordinates."""
    content, offsets = b"", []
    for corners in [CORNERS, [(z, x, y) for x, y, z in CORNERS]]:
        mesh = struct.pack("<I", 0x1002) + b"\0" + struct.pack("<QQ", len(corners), len(FACES))
        mesh += np.array(corners, dtype="<f4").tobytes() + np.array(COORDINATES, dtype="<f4").tobytes()
        mesh += np.array(FACES, dtype="<u4").tobytes()
        offsets.append(len(content))
        content += struct.pack("<HH", 0x041C, 4) + zlib.compress(mesh)
    path.write_bytes(content + struct.pack(f"<{len(offsets)}QI", *offsets, len(offsets)))


def write_files(folder):
    folder.mkdir(parents=True, exist_ok=True)
    random = np.random.default_rng(3)
    write_image(folder / "tile.png", random.uniform(0.1, 0.95, (6, 8, 3)))
    write_image(folder / "grey.png", random.uniform(0.15, 0.8, (6, 8)), raw=True)
    write_image(folder / "bump.png", heights(32), raw=True)
    write_image(folder / "normal.png", normals(heights(32), 4), raw=True)
    write_floats(folder / "half.exr", random.uniform(0.05, 0.9, (5, 7, 3)))
    row, column = np.mgrid[0:8, 0:16]
    sky = np.stack([1 + 0.8 * np.sin(0.4 * column), 1.2 - 0.1 * row, 0.3 + 0.12 * row], axis=-1)
    sky[2, 5] = [9, 8, 6]
    write_floats(folder / "sky.exr", sky)
    write_meshes(folder)
    write_smooth_meshes(folder)
    # Its corners turn as seen from above, its normals point down.
    square = ["v -2 -2 4", "v 0 -2 4", "v 0 0 4", "v -2 0 4", "vn 0 0 -1", "f 1//1 2//1 3//1", "f 1//1 3//1 4//1"]
    (folder / "opposed.obj").write_text("\n".join(square) + "\n")
    write_serialized(folder / "two.serialized")
    (folder / "green.spd").write_text("400 0.1\n480 0.3\n550 0.9\n620 0.4\n700 0.2\n")
