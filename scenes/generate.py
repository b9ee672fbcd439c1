#!/usr/bin/env python3
"""Write the meshes of the scenes that need some, and the rooms and lamps of those that have many.

    python3 generate.py

Every mesh is a binary PLY without normals: where it is curved, the renderer's smooth normals are right. Coordinates are
rounded to 10 µm, so that every machine writes the same bytes. Needs nothing but Python's standard library.
"""

import math
import struct
from pathlib import Path

HERE = Path(__file__).parent


# Meshes: a list of vertices and a list of triangles, counter-clockwise from outside.


def write(name, mesh):
    """Write a mesh as scenes/<name>.ply."""
    vertices, triangles = mesh
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(vertices)}",
        *(f"property float {axis}" for axis in "xyz"),
        f"element face {len(triangles)}",
        "property list uchar int vertex_indices",
        "end_header\n",
    ]
    with open(HERE / f"{name}.ply", "wb") as out:
        out.write("\n".join(header).encode("ascii"))
        for vertex in vertices:
            out.write(struct.pack("<3f", *(round(coordinate, 5) + 0.0 for coordinate in vertex)))
        for triangle in triangles:
            out.write(struct.pack("<B3i", 3, *triangle))


def joined(*meshes):
    """One mesh of several."""
    vertices, triangles = [], []
    for more_vertices, more_triangles in meshes:
        first = len(vertices)
        vertices += more_vertices
        triangles += [tuple(first + corner for corner in triangle) for triangle in more_triangles]
    return vertices, triangles


def rounded(points, rounds=2):
    """A polyline with its corners cut [Chaikin 1974]; the ends stay."""
    for _ in range(rounds):
        cut = [points[0]]
        for a, b in zip(points, points[1:]):
            cut.append(tuple(0.75 * p + 0.25 * q for p, q in zip(a, b)))
            cut.append(tuple(0.25 * p + 0.75 * q for p, q in zip(a, b)))
        points = [*cut, points[-1]]
    return points


def along(path, t):
    """The point of a polyline at t from 0 to 1, each piece as long in t as every other."""
    place = min(max(t, 0), 1) * (len(path) - 1)
    i = min(int(place), len(path) - 2)
    return tuple(a + (place - i) * (b - a) for a, b in zip(path[i], path[i + 1]))


def lathe(profile, segments=48):
    """A surface of revolution about y. The profile of (radius, height) has the inside on its left; it may start and
    end on the axis."""
    vertices, rings = [], []
    for radius, height in profile:
        count = segments if radius > 0 else 1
        first = len(vertices)
        for k in range(count):
            angle = 2 * math.pi * k / segments
            vertices.append((radius * math.cos(angle), height, radius * math.sin(angle)))
        rings.append([first + k % count for k in range(segments + 1)])
    triangles = []
    for lower, upper in zip(rings, rings[1:]):
        for k in range(segments):
            if lower[k] != lower[k + 1]:
                triangles.append((lower[k], upper[k], lower[k + 1]))
            if upper[k] != upper[k + 1]:
                triangles.append((lower[k + 1], upper[k], upper[k + 1]))
    return vertices, triangles


def sheet(point, columns, rows):
    """The open surface point(u, v) for u and v from 0 to 1."""
    vertices = [point(i / columns, j / rows) for j in range(rows + 1) for i in range(columns + 1)]
    triangles = []
    for j in range(rows):
        for i in range(columns):
            a = j * (columns + 1) + i
            b, c, d = a + 1, a + columns + 1, a + columns + 2
            triangles += [(a, b, c), (b, d, c)]
    return vertices, triangles


def tube(center, radius, length, sides=16, closed=False):
    """A tube round the curve center(t), t from 0 to 1, of radius(t), in `length` pieces; open at its ends unless closed."""
    vertices, triangles = [], []
    count = length if closed else length + 1
    for i in range(count):
        t = i / length
        ahead, behind = center(t + 1e-4), center(t - 1e-4)
        tangent = normalized([a - b for a, b in zip(ahead, behind)])
        # Across: any direction that turns little along the curves below, none of which runs along it.
        across = normalized(cross(tangent, (0.31, 0.2, 0.93)))
        other = cross(tangent, across)
        for k in range(sides):
            angle = 2 * math.pi * k / sides
            x, y = radius(t) * math.cos(angle), radius(t) * math.sin(angle)
            vertices.append(tuple(c + x * a + y * o for c, a, o in zip(center(t), across, other)))
    for i in range(length):
        j = (i + 1) % count
        for k in range(sides):
            a, b = i * sides + k, i * sides + (k + 1) % sides
            c, d = j * sides + k, j * sides + (k + 1) % sides
            triangles += [(a, b, c), (b, d, c)]
    return vertices, triangles


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def normalized(vector):
    length = math.sqrt(sum(x * x for x in vector))
    return tuple(x / length for x in vector)


# What the scenes need.


def bottle():
    """A bottle, 0.3 high, of glass 4 mm thick: up the outside, over the lip, down the inside."""
    outside = [(0, 0), (0.03, 0), (0.048, 0), (0.05, 0.012), (0.05, 0.09), (0.05, 0.17), (0.044, 0.205), (0.019, 0.23)]
    neck = [(0.016, 0.26), (0.0165, 0.29), (0.0185, 0.3), (0.0135, 0.3), (0.0125, 0.29), (0.012, 0.26)]
    inside = [(0.015, 0.23), (0.04, 0.203), (0.046, 0.17), (0.046, 0.09), (0.046, 0.016), (0.042, 0.008), (0.02, 0.007), (0, 0.007)]
    return lathe(rounded([*outside, *neck, *inside]), 40)


def carafe():
    """A round carafe, 0.22 high, of glass 5 mm thick."""
    outside = [(0, 0), (0.04, 0), (0.07, 0.004), (0.085, 0.04), (0.078, 0.085), (0.045, 0.12), (0.026, 0.15), (0.026, 0.19)]
    lip = [(0.035, 0.215), (0.036, 0.22), (0.031, 0.22), (0.021, 0.19)]
    inside = [(0.021, 0.15), (0.04, 0.118), (0.073, 0.083), (0.08, 0.04), (0.067, 0.01), (0.035, 0.007), (0, 0.007)]
    return lathe(rounded([*outside, *lip, *inside]), 40)


def teapot():
    """Body and lid by revolution, spout and handle as tubes that end inside of the body."""
    body = [(0, 0), (0.06, 0), (0.08, 0.005), (0.105, 0.06), (0.1, 0.11), (0.07, 0.145), (0.055, 0.15)]
    lid = [(0.05, 0.158), (0.025, 0.168), (0.008, 0.17), (0.012, 0.185), (0.016, 0.195), (0.008, 0.203), (0, 0.203)]

    def spout(t):
        return (0.075 + 0.105 * t, 0.06 + 0.085 * t * t * (3 - 2 * t), 0)

    def handle(t):
        angle = math.pi * (0.5 + t)
        return (-0.085 + 0.075 * math.cos(angle), 0.078 + 0.05 * math.sin(angle), 0)

    return joined(
        lathe(rounded([*body, *lid])),
        tube(spout, lambda t: 0.028 - 0.016 * t, 24),
        tube(handle, lambda t: 0.008, 32, 12),
    )


def concert_hall():
    """Five walls like sails. Each stands on an arc and leans, turns and bulges on its way up, so that none of its
    rulings is parallel to the next."""
    # Center of the arc's chord (x, z), its direction in degrees, length, height, lean, twist in degrees, bulge.
    walls = [
        (-5.2, -3.2, 62, 9.0, 6.5, 1.6, 26, 1.3),
        (-1.6, -6.6, 14, 8.0, 9.5, -1.2, -30, 1.5),
        (3.2, -5.4, -28, 7.5, 7.5, 1.5, 24, 1.2),
        (6.0, -0.6, -74, 9.0, 5.5, 1.2, -22, 1.4),
        (0.6, -8.6, -6, 12.0, 12.5, 1.0, 18, 1.8),
    ]

    def wall(x, z, direction, length, height, lean, twist, bulge):
        def point(u, v):
            angle = math.radians(direction + twist * v)
            along = (u - 0.5) * length * (1 + 0.15 * v)
            # Outwards is away from the court; the belly of the arc lies there, and moves along the wall with v.
            outwards = bulge * (1 - (2 * u - 1) ** 2) * (1 - 0.5 * v) + lean * v * v
            outwards += 0.5 * v * math.sin(2 * math.pi * (u + 0.3 * v))
            rise = height * v * (1 + 0.22 * (u - 0.5) * math.copysign(1, twist))
            return (
                x + along * math.cos(angle) - outwards * math.sin(-angle),
                rise,
                z - along * math.sin(angle) - outwards * math.cos(angle),
            )

        return sheet(point, 36, 28)

    return joined(*(wall(*numbers) for numbers in walls))


def basin():
    """A bowl on a foot, 1 across and 0.5 high, outside and inside."""
    outside = [(0, 0), (0.1, 0), (0.16, 0.01), (0.2, 0.03), (0.36, 0.12), (0.46, 0.3), (0.49, 0.48)]
    inside = [(0.5, 0.5), (0.48, 0.5), (0.45, 0.48), (0.41, 0.3), (0.32, 0.15), (0.15, 0.08), (0, 0.075)]
    return lathe(rounded([*outside, *inside]))


def tap():
    """A pipe that rises, bends forward (+z) and points down."""
    path = rounded([(0, 0, 0), (0, 0.13, 0), (0, 0.22, 0.01), (0, 0.24, 0.07), (0, 0.2, 0.13), (0, 0.13, 0.14)], 3)
    return tube(lambda t: along(path, t), lambda t: 0.014, len(path) - 1, 14)


def chair_shell():
    """Seat and back of a chair in one curved sheet, its seat 0.46 high; the one who sits looks at +z."""
    profile = rounded([(0.45, 0.25), (0.475, 0.19), (0.44, -0.12), (0.47, -0.21), (0.88, -0.28)], 3)

    def point(u, v):
        y, z = along(profile, v)
        across = (2 * u - 1) ** 2
        # The seat is hollow, the back wraps round the one who sits, and its upper corners are rounded.
        half = 0.23 * (1 - 0.25 * max(0, v - 0.8) ** 2 / 0.04)
        return ((1 - 2 * u) * half, y + 0.02 * across * (1 - v), z + 0.06 * across * v)

    return sheet(point, 16, 28)


def chair_frame():
    """One bent tube: the rails under the seat, down at the front, and back over the floor."""
    left = [(-0.17, 0.437, -0.12), (-0.19, 0.437, 0.1), (-0.19, 0.437, 0.24), (-0.21, 0.23, 0.25), (-0.21, 0.02, 0.26), (-0.21, 0.02, 0)]
    path = rounded([*left, (-0.21, 0.02, -0.27), (0.21, 0.02, -0.27), *((-x, y, z) for x, y, z in reversed(left))], 3)
    return tube(lambda t: along(path, t), lambda t: 0.012, len(path) - 1, 10)


def table_top():
    """The top of a long table, 4.4 by 1.5 and 4 cm thick, its outline a superellipse."""

    def power(x):
        return math.copysign(abs(x) ** 0.6, x)

    turns = (2 * math.pi * k / 72 for k in range(72))
    outline = [(round(2.2 * power(math.cos(a)), 5), round(0.75 * power(math.sin(a)), 5)) for a in turns]
    return extruded([outline], 0.04)


def knot():
    """A trefoil knot, about 1 across."""

    def center(t):
        angle = 2 * math.pi * t
        reach = 0.3 + 0.13 * math.cos(3 * angle)
        return (reach * math.cos(2 * angle), reach * math.sin(2 * angle), 0.15 * math.sin(3 * angle))

    # The offset keeps every ring's frame away from the knot's own directions.
    return tube(center, lambda t: 0.065, 180, 16, closed=True)


def vase():
    """A vase, 1 high, outside and inside."""
    outside = [(0, 0), (0.12, 0), (0.16, 0.01), (0.27, 0.3), (0.29, 0.55), (0.2, 0.75), (0.1, 0.86), (0.12, 0.95)]
    inside = [(0.18, 1), (0.165, 1), (0.1, 0.94), (0.08, 0.86), (0.17, 0.74), (0.26, 0.55), (0.24, 0.3), (0.12, 0.05), (0, 0.045)]
    return lathe(rounded([*outside, *inside]), 32)


def face():
    """A square panel from -1 to 1 in x and y, z from -0.06 to 0, with eyes, a nose and a mouth cut through it."""
    holes = [
        [(-0.68, 0.2), (-0.16, 0.2), (-0.42, 0.64)],
        [(0.16, 0.2), (0.68, 0.2), (0.42, 0.64)],
        [(-0.13, -0.12), (0.13, -0.12), (0, 0.14)],
        [(-0.7, -0.3), (-0.46, -0.58), (-0.2, -0.68), (-0.2, -0.52), (0.02, -0.52), (0.02, -0.7), (0.24, -0.67),
         (0.48, -0.57), (0.7, -0.3), (0.44, -0.42), (0.3, -0.47), (0.3, -0.33), (0.08, -0.33), (0.08, -0.5), (-0.3, -0.46)],
    ]
    return extruded([[(-1, -1), (1, -1), (1, 1), (-1, 1)], *holes], 0.06)


def extruded(loops, depth):
    """A plate of the given thickness below z = 0 with straight sides. The first loop is its rim, the others are holes,
    all counter-clockwise. No triangles share vertices, so normals are those of the faces."""
    edges = [(a, b) for loop in loops for a, b in zip(loop, [*loop[1:], loop[0]])]
    heights = sorted({y for loop in loops for _, y in loop})
    quads = []
    for low, high in zip(heights, heights[1:]):
        # Between two neighboring heights edges are straight and do not cross: pairs of them bound trapezoids.
        middle = (low + high) / 2
        spans = sorted((at(edge, middle), at(edge, low), at(edge, high)) for edge in edges if crosses(edge, middle))
        for (_, left_low, left_high), (_, right_low, right_high) in zip(spans[::2], spans[1::2]):
            corners = [(left_low, low), (right_low, low), (right_high, high), (left_high, high)]
            quads.append([(x, y, 0) for x, y in corners])
            quads.append([(x, y, -depth) for x, y in reversed(corners)])
    for number, loop in enumerate(loops):
        for a, b in zip(loop, [*loop[1:], loop[0]]):
            if number > 0:
                a, b = b, a
            quads.append([(*a, -depth), (*b, -depth), (*b, 0), (*a, 0)])
    vertices, triangles = [], []
    for quad in quads:
        for triangle in ((0, 1, 2), (0, 2, 3)):
            corners = [quad[k] for k in triangle]
            if len(set(corners)) == 3:
                triangles.append(tuple(range(len(vertices), len(vertices) + 3)))
                vertices += corners
    return vertices, triangles


def crosses(edge, y):
    (_, y0), (_, y1) = edge
    return min(y0, y1) < y < max(y0, y1)


def at(edge, y):
    """The x of an edge at height y; its own end where it ends there, so that neighbors meet exactly."""
    (x0, y0), (x1, y1) = edge
    if y in (y0, y1):
        return x0 if y == y0 else x1
    return x0 + (x1 - x0) * (y - y0) / (y1 - y0)


def house(inset):
    """The shell of a house whose front gable stands in the xy plane and whose back lies at z = -2.6: 2.2 wide, eaves at
    1.5, ridge at 2.4, down to 0.1 below the ground; `inset` inwards from that on all sides but below."""
    slope = math.hypot(0.9, 1.1)
    # The roof moves along its normal, so that the eaves come down by what the slope makes of it.
    ridge = 2.4 - inset * slope / 1.1
    wall = 1.1 - inset
    eaves = ridge - 0.9 / 1.1 * wall
    outline = [(-wall, -0.1), (wall, -0.1), (wall, eaves), (0, ridge), (-wall, eaves)]
    vertices, triangles = extruded([outline], 2.6 - 2 * inset)
    return [(x, y, z - inset) for x, y, z in vertices], triangles


def lamps_of_the_house():
    """Forty balls of light under the roof of the house, which stands at (-1.9, 0, -0.6): two layers of four rows of five."""
    lines = ['<scene version="3.0.0">', "  <!-- Written by ../generate.py: the 40 lamps in the house. -->"]
    for layer in range(2):
        for row in range(4):
            for column in range(5):
                x, y, z = -2.7 + 0.4 * column, 0.5 + 0.7 * layer, -0.95 - 0.63 * row
                lines += [
                    f'  <shape type="sphere"><point name="center" x="{x:.2f}" y="{y:.2f}" z="{z:.2f}"/>'
                    '<float name="radius" value="0.1"/><ref id="lime"/>'
                    '<emitter type="area"><rgb name="radiance" value="$radiance"/></emitter></shape>',
                ]
    (HERE / "house-of-lamps" / "lamps.xml").write_text("\n".join([*lines, "</scene>", ""]))


def ten_by_ten_rooms():
    """The instances of scene10's room, 4 m apart, and the lamp of each."""
    lines = [
        '<scene version="3.0.0">',
        "  <!-- Written by ../generate.py: 10 × 10 instances of the room, each with its lamp. -->",
    ]
    for row in range(10):
        for column in range(10):
            x, z = 4 * column - 18, 4 * row - 18
            move = f'<translate x="{x}" z="{z}"/>'
            lamp = f'<scale x="0.3" y="0.3"/><rotate x="1" angle="90"/><translate x="{x}" y="2.49" z="{z}"/>'
            lines += [
                f'  <shape type="instance"><transform name="to_world">{move}</transform><ref id="room"/></shape>',
                f'  <shape type="rectangle"><transform name="to_world">{lamp}</transform><ref id="white"/>'
                '<emitter type="area"><rgb name="radiance" value="$radiance"/></emitter></shape>',
            ]
    (HERE / "scene10" / "rooms.xml").write_text("\n".join([*lines, "</scene>", ""]))


def closed_rooms(count, seen):
    """count × count closed rooms of many-rooms, 4 m apart, with their furniture, and the lamps of all but the one at the
    origin, which is number `seen` in its row and in its column."""
    low, high = -4 * seen - 2, 4 * (count - seen) - 2
    middle, half = (low + high) / 2, (high - low) / 2
    title = f"  <!-- Written by ../generate.py: {count} × {count} closed rooms"
    rooms = [
        '<scene version="3.0.0">',
        f"{title}. Walls of 10 cm, from below the floor to above the ceiling. -->",
        f'  <shape type="rectangle" id="floor"><transform name="to_world"><scale x="{half}" y="{half}"/><rotate x="1" angle="-90"/>'
        f'<translate x="{middle}" z="{middle}"/></transform><ref id="boards"/></shape>',
        f'  <shape type="rectangle" id="ceiling"><transform name="to_world"><scale x="{half}" y="{half}"/><rotate x="1" angle="90"/>'
        f'<translate x="{middle}" y="2.5" z="{middle}"/></transform><ref id="plaster"/></shape>',
    ]
    for k in range(count + 1):
        place = low + 4 * k
        rooms += [
            f'  <shape type="cube"><transform name="to_world"><scale x="0.05" y="1.3" z="{half + 0.05}"/>'
            f'<translate x="{place}" y="1.25" z="{middle}"/></transform><ref id="green"/></shape>',
            f'  <shape type="cube"><transform name="to_world"><scale x="{half + 0.05}" y="1.3" z="0.05"/>'
            f'<translate x="{middle}" y="1.25" z="{place}"/></transform><ref id="plaster"/></shape>',
        ]
    lamps = ['<scene version="3.0.0">', f"{title}: the lamps of all but the one that is seen. -->"]
    for row in range(count):
        for column in range(count):
            x, z = 4 * (column - seen), 4 * (row - seen)
            move = f'<translate x="{x}" z="{z}"/>'
            rooms.append(f'  <shape type="instance"><transform name="to_world">{move}</transform><ref id="furniture"/></shape>')
            if (row, column) != (seen, seen):
                lamp = f'<scale x="0.25" y="0.25"/><rotate x="1" angle="90"/><translate x="{x}" y="2.49" z="{z}"/>'
                lamps.append(
                    f'  <shape type="rectangle"><transform name="to_world">{lamp}</transform><ref id="plaster"/>'
                    '<emitter type="area"><rgb name="radiance" value="$radiance"/></emitter></shape>'
                )
    for name, lines in ((f"rooms-{count**2}", rooms), (f"lamps-{count**2}", lamps)):
        (HERE / "many-rooms" / f"{name}.xml").write_text("\n".join([*lines, "</scene>", ""]))


def main():
    write("kitchen-counter/bottle", bottle())
    write("kitchen-counter/carafe", carafe())
    write("kitchen-counter/teapot", teapot())
    write("concert-hall/walls", concert_hall())
    write("bathroom/basin", basin())
    write("bathroom/tap", tap())
    write("gallery/knot", knot())
    write("gallery/vase", vase())
    write("rooms/vase", vase())
    write("jack-o-lantern/face", face())
    write("conference/chair-shell", chair_shell())
    write("conference/chair-frame", chair_frame())
    write("conference/table-top", table_top())
    write("house-of-lamps/outside", house(0))
    write("house-of-lamps/inside", house(0.06))
    lamps_of_the_house()
    ten_by_ten_rooms()
    closed_rooms(5, 2)
    closed_rooms(10, 5)


if __name__ == "__main__":
    main()
