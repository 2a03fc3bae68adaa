#!/usr/bin/env python3
"""Writes the generated parts of ../atelier.pbrt: meshes, leaves and textures.

Run it in this folder. Same seed, same files; needs numpy and Pillow.
"""
import gzip
import math
import random
import struct

import numpy as np
from PIL import Image, ImageDraw, ImageFont

random.seed(1840)  # the year of Petzval's portrait lens
noise = np.random.default_rng(1840)


# Meshes.


def corners(profile, sharp=0.5):
    """Points of a profile (r, z) with their normals; a corner sharper than that (rad) is two.

    Answers the points, and the pairs of them that bound a face.
    """
    profile = [p for i, p in enumerate(profile) if i == 0 or math.dist(p, profile[i - 1]) > 1e-7]
    sides = []
    for (r, z), (next_r, next_z) in zip(profile, profile[1:]):
        length = math.hypot(next_r - r, next_z - z)
        sides.append(((next_z - z) / length, (r - next_r) / length))
    points, faces = [(*profile[0], sides[0])], []
    for i, point in enumerate(profile[1:], 1):
        faces.append((len(points) - 1, len(points)))
        before, after = sides[i - 1], sides[min(i, len(sides) - 1)]
        if before[0] * after[0] + before[1] * after[1] < math.cos(sharp):
            points += [(*point, before), (*point, after)]
        else:
            n = (before[0] + after[0], before[1] + after[1])
            length = math.hypot(*n)
            points.append((*point, (n[0] / length, n[1] / length)))
    return points, faces


def lathe(path, profile, segments):
    """Turns a profile about z; the outside is on the right of its way."""
    points, bands = corners(profile)
    vertices, faces = [], []
    for r, z, (nr, nz) in points:
        for k in range(segments):
            a = 2 * math.pi * k / segments
            c, s = math.cos(a), math.sin(a)
            vertices.append((r * c, r * s, z, nr * c, nr * s, nz))
    for low, high in bands:
        for k in range(segments):
            next_k = (k + 1) % segments
            faces.append([low * segments + k, low * segments + next_k, high * segments + next_k, high * segments + k])
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        "property float nx\nproperty float ny\nproperty float nz\n"
        f"element face {len(faces)}\nproperty list uchar short vertex_indices\nend_header\n"
    )
    rows = [struct.pack("<6f", *vertex) for vertex in vertices]
    rows += [struct.pack("<B4h", 4, *face) for face in faces]
    with open(path, "wb") as out:
        out.write(gzip.compress(header.encode() + b"".join(rows), mtime=0))


def bead(r, z, radius, first, last, count=6):
    """An arc of a circle about (r, z), from one angle to the other (degrees, 0 is outwards)."""
    angles = [math.radians(first + (last - first) * i / count) for i in range(count + 1)]
    return [(r + radius * math.cos(a), z + radius * math.sin(a)) for a in angles]


def numbers(values, digits=4):
    return " ".join(f"{v:.{digits}f}".rstrip("0").rstrip(".") for row in values for v in row)


def loop(out, points, triangles, levels=3):
    out.write(f'Shape "loopsubdiv" "integer levels" {levels}\n    "point3 P" [ {numbers(points)} ]\n')
    out.write(f'    "integer indices" [ {" ".join(str(i) for t in triangles for i in t)} ]\n')


def turned(out, profile, segments=12, levels=3):
    """A profile (r, y) turned about y as a subdivision surface; r = 0 at an end closes it."""
    points, rings = [], []
    for r, y in profile:
        count = 1 if r == 0 else segments
        rings.append(range(len(points), len(points) + count))
        for k in range(count):
            a = 2 * math.pi * k / segments
            points.append((r * math.cos(a), y, r * math.sin(a)))
    triangles = []
    for low, high in zip(rings, rings[1:]):
        for k in range(segments):
            a, b = low[k % len(low)], low[(k + 1) % len(low)]
            c, d = high[k % len(high)], high[(k + 1) % len(high)]
            if a != b:
                triangles.append((a, d, b) if c != d else (a, c, b))
            if c != d:
                triangles.append((a, c, d))
    loop(out, points, triangles, levels)


def torus(out, major, minor, around=24, across=6):
    """About z."""
    points = []
    for i in range(around):
        for j in range(across):
            a, b = 2 * math.pi * i / around, 2 * math.pi * j / across
            r = major + minor * math.cos(b)
            points.append((r * math.cos(a), r * math.sin(a), minor * math.sin(b)))
    triangles = []
    for i in range(around):
        for j in range(across):
            a, b = i * across + j, i * across + (j + 1) % across
            c, d = (i + 1) % around * across + j, (i + 1) % around * across + (j + 1) % across
            triangles += [(a, c, d), (a, d, b)]
    loop(out, points, triangles, 3)


def box(out, low, high, chamfer, per_metre, grain="x"):
    """A box with chamfered edges; texture coordinates run along the grain, in 1 / m."""
    points, normals, uvs, triangles = [], [], [], []

    def face(corners, normal):
        first = len(points)
        for p in corners:
            points.append(p)
            normals.append(normal)
            axis = max(range(3), key=lambda k: abs(normal[k]))
            rest = [k for k in range(3) if k != axis]
            along = "xyz".index(grain)
            if along in rest:
                rest.sort(key=lambda k: k != along)
            uvs.append((p[rest[0]] * per_metre + 0.31 * axis, p[rest[1]] * per_metre + 0.17 * axis))
        for i in range(1, len(corners) - 1):
            a, b, c = corners[0], corners[i], corners[i + 1]
            u = [b[k] - a[k] for k in range(3)]
            v = [c[k] - a[k] for k in range(3)]
            turn = sum(
                (u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]) * normal[k]
                for k in range(3)
            )
            t = (first, first + i, first + i + 1)
            triangles.append(t if turn > 0 else (t[0], t[2], t[1]))

    ends = (low, high)
    sign = (-1, 1)

    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for s in (0, 1):
            corners_ = []
            for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
                p = [0, 0, 0]
                p[axis] = ends[s][axis]
                p[u] = ends[a][u] - sign[a] * chamfer
                p[v] = ends[b][v] - sign[b] * chamfer
                corners_.append(tuple(p))
            n = [0, 0, 0]
            n[axis] = sign[s]
            face(corners_, tuple(n))
        for a in (0, 1):
            for b in (0, 1):
                strip = []
                for s, inset in ((0, u), (0, v), (1, v), (1, u)):
                    p = [0, 0, 0]
                    p[axis] = ends[s][axis] - sign[s] * chamfer
                    p[u] = ends[a][u] - (sign[a] * chamfer if inset == u else 0)
                    p[v] = ends[b][v] - (sign[b] * chamfer if inset == v else 0)
                    strip.append(tuple(p))
                n = [0, 0, 0]
                n[u], n[v] = sign[a] * 0.7071, sign[b] * 0.7071
                face(strip, tuple(n))
    for a in (0, 1):
        for b in (0, 1):
            for c in (0, 1):
                tip = [ends[i][k] for k, i in enumerate((a, b, c))]
                s = (sign[a], sign[b], sign[c])
                corners_ = []
                for k in range(3):
                    p = [tip[m] - s[m] * chamfer * (m != k) for m in range(3)]
                    corners_.append(tuple(p))
                face(corners_, tuple(0.5774 * q for q in s))
    out.write(f'Shape "trianglemesh"\n    "point3 P" [ {numbers(points)} ]\n')
    out.write(f'    "normal N" [ {numbers(normals, 3)} ]\n    "point2 uv" [ {numbers(uvs, 3)} ]\n')
    out.write(f'    "integer indices" [ {" ".join(str(i) for t in triangles for i in t)} ]\n')


def portrait_lens():
    """The barrel in brass, z forwards from its flange; the front element stands at z = 0.080."""
    profile = (
        [(0.0405, 0.0)] + bead(0.0395, 0.004, 0.001, 0, 90, 3) + [(0.0325, 0.005), (0.0305, 0.007)]
        + [(0.0295, 0.0085), (0.0295, 0.0125)]
        + bead(0.0295, 0.0145, 0.002, -90, 90) + [(0.0295, 0.0170), (0.0295, 0.0360)]
        + bead(0.0295, 0.0375, 0.0015, -90, 90) + [(0.0295, 0.0395), (0.0295, 0.0400)]
        # The engraved ring goes here, as a cylinder of its own.
        + [(0.0310, 0.0412), (0.0310, 0.0418), (0.0304, 0.0418), (0.0304, 0.0622), (0.0310, 0.0622), (0.0310, 0.0628)]
        + [(0.0300, 0.0640), (0.0300, 0.0660)] + bead(0.0310, 0.0680, 0.0018, -120, 120)
        + [(0.0298, 0.0710), (0.0300, 0.0740), (0.0310, 0.0790), (0.0328, 0.0850), (0.0345, 0.0890)]
        + bead(0.0345, 0.0912, 0.0022, -80, 180, 10) + [(0.0322, 0.0880), (0.0300, 0.0850), (0.0290, 0.0845), (0.0275, 0.0845)]
    )
    lathe("barrel.ply.gz", profile, 72)


def knob():
    profile = [(0.0030, 0.0), (0.0030, 0.009), (0.0085, 0.010)] + bead(0.0095, 0.0112, 0.001, -80, 0, 3)
    profile += [(0.0105, 0.0150)] + bead(0.0095, 0.0152, 0.001, 0, 90, 3) + [(0.004, 0.0168), (0.0002, 0.0170)]
    lathe("knob.ply.gz", profile, 40)


def turnery():
    """What is round and smooth: stands, a bottle, the foot of a lamp, rings."""
    with open("globe.pbrt", "w") as out:
        profile = [(0, 0), (0.048, 0), (0.05, 0.001), (0.05, 0.008), (0.046, 0.010), (0.03, 0.014)]
        profile += [(0.012, 0.022), (0.009, 0.030), (0.016, 0.036), (0.016, 0.040), (0.008, 0.046), (0.007, 0.06), (0, 0.062)]
        turned(out, profile)
    with open("meridian.pbrt", "w") as out:
        torus(out, 0.0815, 0.0022)
    with open("loupe.pbrt", "w") as out:
        torus(out, 0.0425, 0.0032)
    with open("foot.pbrt", "w") as out:
        profile = [(0, 0), (0.032, 0), (0.034, 0.0005), (0.034, 0.003), (0.031, 0.0045), (0.012, 0.007)]
        profile += [(0.0045, 0.012), (0.0035, 0.02), (0.0055, 0.026), (0.0055, 0.029), (0.0032, 0.033), (0.0032, 0.052), (0, 0.053)]
        turned(out, profile)
    with open("bottle.pbrt", "w") as out:
        outer = [(0, 0), (0.022, 0), (0.025, 0.002), (0.027, 0.02), (0.026, 0.05), (0.02, 0.062), (0.010, 0.068), (0.0085, 0.085), (0.012, 0.088)]
        inner = [(0.0115, 0.090), (0.007, 0.087), (0.0065, 0.070), (0.017, 0.058), (0.022, 0.048), (0.023, 0.02), (0.02, 0.006), (0, 0.005)]
        turned(out, outer + inner)
    with open("lamp.pbrt", "w") as out:
        profile = [(0, 0), (0.05, 0), (0.052, 0.001), (0.052, 0.010), (0.04, 0.014), (0.02, 0.02), (0.026, 0.045), (0.040, 0.07)]
        profile += [(0.038, 0.09), (0.015, 0.108), (0.009, 0.115), (0.009, 0.15), (0, 0.151)]
        turned(out, profile)


def cloth():
    """A polishing cloth, dropped: its folds run together towards a corner."""
    n, points, triangles = 15, [], []
    for j in range(n):
        for i in range(n):
            u, v = i / (n - 1) - 0.5, j / (n - 1) - 0.5
            fold = math.sin(17 * (u + 0.4 * v) + 2 * math.sin(4 * v)) + 0.6 * math.sin(11 * v - 9 * u + 1)
            rim = 1 - (2 * max(abs(u), abs(v))) ** 4 * 0.75
            y = 0.0016 + 0.0075 * rim * max(0, 0.55 + 0.6 * fold)
            x = 0.135 * u * (1 - 0.25 * v) + 0.006 * math.sin(9 * v)
            z = 0.115 * v + 0.006 * math.sin(8 * u + 1)
            points.append((x, y, z))
    for j in range(n - 1):
        for i in range(n - 1):
            a = j * n + i
            triangles += [(a, a + n, a + n + 1), (a, a + n + 1, a + 1)]
    with open("cloth.pbrt", "w") as out:
        loop(out, points, triangles, 3)


def boxes():
    with open("camera.pbrt", "w") as out:
        # The lens looks along -z; the box stands on the table, and slides in a second one.
        box(out, (-0.058, 0.006, 0.0), (0.058, 0.118, 0.085), 0.0012, 4, "x")
        box(out, (-0.052, 0.012, 0.08), (0.052, 0.112, 0.15), 0.0012, 4, "x")
        box(out, (-0.066, 0.0, -0.008), (0.066, 0.0075, 0.17), 0.0012, 4, "z")
        box(out, (-0.046, 0.0165, -0.004), (0.046, 0.1085, 0.001), 0.0010, 4, "x")


def shade():
    """The frustum of the lamp's shade: bilinear patches between two circles, with a rim."""
    n, points, normals, uvs, patches = 48, [], [], [], []
    low, high, height = 0.088, 0.052, 0.120
    slope = math.hypot(low - high, height)
    for i in range(n + 1):
        a = 2 * math.pi * i / n
        for r, y in ((low, 0.0), (high, height)):
            points.append((r * math.cos(a), y, r * math.sin(a)))
            normals.append((math.cos(a) * height / slope, (low - high) / slope, math.sin(a) * height / slope))
            uvs.append((i / n, y / height))
    for i in range(n):
        patches.append((2 * i, 2 * i + 2, 2 * i + 1, 2 * i + 3))
    with open("shade.pbrt", "w") as out:
        out.write(f'Shape "bilinearmesh"\n    "point3 P" [ {numbers(points)} ]\n')
        out.write(f'    "normal N" [ {numbers(normals, 3)} ]\n    "point2 uv" [ {numbers(uvs, 3)} ]\n')
        out.write(f'    "integer indices" [ {" ".join(str(i) for p in patches for i in p)} ]\n')


def leaf(out):
    """A curved strip 34 mm long along z, that an alpha texture cuts to shape."""
    points, uvs, patches = [], [], []
    for j in range(5):
        t = j / 4
        y = 0.006 * math.sin(math.pi * t) - 0.004 * t * t
        for k in range(3):
            x = (k - 1) * 0.0085
            points.append((x, y + (0.0022 if k != 1 else 0.0), 0.034 * t))
            uvs.append((k / 2, t))
    for j in range(4):
        for k in range(2):
            a = 3 * j + k
            patches.append((a, a + 1, a + 3, a + 4))
    out.write(f'    Shape "bilinearmesh" "texture alpha" "leaf alpha"\n        "point3 P" [ {numbers(points)} ]\n')
    out.write(f'        "point2 uv" [ {numbers(uvs, 3)} ]\n')
    out.write(f'        "integer indices" [ {" ".join(str(i) for p in patches for i in p)} ]\n')


def sprig():
    """Stems from the mouth of a bottle, at the origin, with leaves in pairs along them."""
    with open("leaf.pbrt", "w") as out:
        out.write('ObjectBegin "leaf"\n    NamedMaterial "leaf"\n')
        leaf(out)
        out.write("ObjectEnd\n")
    with open("sprig.pbrt", "w") as out:
        stems = [(-0.036, 0.100, 0.010), (0.026, 0.112, 0.022), (-0.008, 0.122, -0.012), (0.056, 0.072, 0.000), (-0.062, 0.060, -0.016)]
        for s, tip in enumerate(stems):

            def at(t):
                bend = t * t
                return (tip[0] * (0.25 * t + 0.75 * bend), tip[1] * (t - 0.12 * bend) / 0.88, tip[2] * (0.25 * t + 0.75 * bend))

            # A stem: a tube of triangles, smoothed.
            points, triangles, sides, rings = [], [], 5, 9
            for j in range(rings):
                t = -0.35 + 1.35 * j / (rings - 1)
                x, y, z = at(max(t, 0)) if t > 0 else (0.01 * t, tip[1] * t, 0)
                r = 0.0011 * (1 - 0.6 * max(t, 0))
                for k in range(sides):
                    a = 2 * math.pi * k / sides
                    points.append((x + r * math.cos(a), y, z + r * math.sin(a)))
            for j in range(rings - 1):
                for k in range(sides):
                    a, b = j * sides + k, j * sides + (k + 1) % sides
                    triangles += [(a, a + sides, b + sides), (a, b + sides, b)]
            out.write('NamedMaterial "stem"\n')
            loop(out, points, triangles, 2)
            pairs = int(11 * tip[1] / 0.11)
            for i in range(pairs):
                t = 0.22 + 0.78 * i / (pairs - 1)
                x, y, z = at(t)
                for side in (0, 180):
                    yaw = (137 if i % 2 else 40) + side + random.uniform(-25, 25)
                    pitch = -random.uniform(15, 55) if i < pairs - 1 else -70
                    size = random.uniform(0.72, 1.05) * (1.1 - 0.45 * t)
                    out.write(f"AttributeBegin\n    Translate {x:.4f} {y:.4f} {z:.4f}\n    Rotate {yaw:.0f} 0 1 0\n    Rotate {pitch:.0f} 1 0 0\n")
                    out.write(f'    Scale {size:.2f} {size:.2f} {size:.2f}\n    ObjectInstance "leaf"\nAttributeEnd\n')


def books():
    """A row of books, spines towards the camera, and a pair lying down: rounded backs, gold bands."""
    row = [("red", 0.030, 0.158, 3), ("brown", 0.022, 0.172, 2), ("green", 0.036, 0.148, 4), ("brown", 0.026, 0.164, 3), ("red", 0.024, 0.150, 2)]
    with open("book.pbrt", "w") as out:
        box(out, (-0.5, 0.0, 0.0), (0.5, 1.0, 1.0), 0.012, 1, "y")
    with open("books.pbrt", "w") as out:
        x = 0.120
        for colour, width, height, bands in row:
            out.write(f"AttributeBegin\n    Translate {x + width / 2:.4f} 0 {0.30 + random.uniform(0, 0.012):.4f}\n")
            out.write(f'    NamedMaterial "{colour} leather"\n    AttributeBegin\n        Scale {width:.4f} {height:.4f} 0.11\n        Include "atelier/book.pbrt"\n    AttributeEnd\n')
            out.write("    Rotate -90 1 0 0\n    Scale 1 0.35 1\n")
            out.write(f'    Shape "cylinder" "float radius" {width / 2:.4f} "float zmin" 0 "float zmax" {height:.4f}\n')
            out.write('    NamedMaterial "gold"\n')
            for i in range(bands):
                z = height * (0.14 + 0.72 * i / (bands - 1))
                out.write(f'    Shape "cylinder" "float radius" {width / 2 + 0.0004:.4f} "float zmin" {z:.4f} "float zmax" {z + 0.0035:.4f}\n')
            out.write("AttributeEnd\n")
            x += width + 0.0015


def candles():
    """Candles on sticks along the wall."""
    with open("candles.pbrt", "w") as out:
        out.write('ObjectBegin "candlestick"\n    NamedMaterial "brass"\n    Rotate -90 1 0 0\n')
        out.write('    Shape "cone" "float radius" 0.03 "float height" 0.05\n    Shape "cylinder" "float radius" 0.005 "float zmin" 0 "float zmax" 0.3\n')
        out.write('    Shape "sphere" "float radius" 0.012\n    NamedMaterial "wax"\n')
        out.write('    Shape "cylinder" "float radius" 0.009 "float zmin" 0.3 "float zmax" 0.36\nObjectEnd\n')
        places = [(-0.47, 0.19), (-0.36, 0.27), (-0.27, 0.17), (-0.02, 0.235), (0.21, 0.29), (0.30, 0.20), (0.40, 0.26), (0.50, 0.18)]
        for i, (x, y) in enumerate(places):
            z = random.uniform(1.0, 1.22)
            out.write(f'AttributeBegin\n    Translate {x:.3f} {y - 0.37:.3f} {z:.3f}\n    ObjectInstance "candlestick"\n')
            out.write(f'    AreaLightSource "diffuse" "blackbody L" {random.choice((1900, 2000, 2150))} "float scale" 15\n')
            out.write('    Translate 0 0.374 0\n    Scale 0.8 1.5 0.8\n    NamedMaterial "wax"\n    Shape "sphere" "float radius" 0.006\nAttributeEnd\n')


# Textures.


def smooth(shape, sigma):
    """Noise without seams, blurred by Gaussians of these widths in pixels, 0 to 1."""
    field = noise.standard_normal(shape)
    fy = np.fft.fftfreq(shape[0])[:, None]
    fx = np.fft.fftfreq(shape[1])[None, :]
    blur = np.exp(-2 * np.pi**2 * ((fy * sigma[0]) ** 2 + (fx * sigma[1]) ** 2))
    field = np.fft.ifft2(np.fft.fft2(field) * blur).real
    low, high = np.percentile(field, [0.5, 99.5])
    return np.clip((field - low) / (high - low), 0, 1)


def save(path, pixels, **options):
    Image.fromarray((np.clip(pixels, 0, 1) * 255 + 0.5).astype(np.uint8)).save(path, **options)


def wood():
    h = w = 512
    y = np.arange(h)[:, None] / h
    rings = smooth((h, w), (26, 150)) * 1.0 + 0.16 * smooth((h, w), (5, 90))
    bands = 0.5 + 0.5 * np.cos(2 * np.pi * (9 * rings + 3 * y))
    pores = smooth((h, w), (0.7, 16))
    grain = 0.62 * bands + 0.38 * smooth((h, w), (2, 60))
    dark, light = np.array([0.27, 0.135, 0.07]), np.array([0.50, 0.29, 0.16])
    colour = dark + (light - dark) * grain[..., None]
    colour *= (1 - 0.55 * np.clip((pores - 0.66) * 4, 0, 1))[..., None]
    save("wood.jpg", colour ** (1 / 1.6), quality=82)
    save("grain.png", 0.6 + 0.4 * smooth((128, 128), (1.0, 12)) - 0.5 * np.clip((pores[::4, ::4] - 0.6) * 3, 0, 1))


def leather():
    """Heights of a pebbled skin."""
    a = smooth((128, 128), (1.6, 1.6))
    b = smooth((128, 128), (4, 4))
    save("leather.png", np.abs(a - 0.5) * 1.4 + 0.3 * b)


def patina():
    a = smooth((128, 128), (9, 9)) * 0.65 + smooth((128, 128), (2, 2)) * 0.35
    save("patina.png", np.clip((a - 0.52) * 4.5, 0, 1))


def engraving():
    text = "PETZVAL  \u00b7  WIEN  1840  \u00b7  N\u00ba 7  \u00b7  150 mm  f/3.6  \u00b7  "
    w, h = 2048, 200
    big = Image.new("L", (w * 2, h * 2), 0)
    draw = ImageDraw.Draw(big)
    font = ImageFont.load_default(size=168)
    width = draw.textlength(text, font=font)
    tile = Image.new("L", (int(width), h * 2), 0)
    ImageDraw.Draw(tile).text((0, 90), text, fill=255, font=font)
    tile = tile.resize((w, h * 2))
    for x in (0, w):
        big.paste(tile, (x, 0))
    draw = ImageDraw.Draw(big)
    for y in (26, h * 2 - 26):
        draw.line((0, y, w * 2, y), fill=255, width=7)
    big.resize((w, h), Image.LANCZOS).quantize(8).convert("L").save("engraving.png", optimize=True)


def sky_globe():
    """The night sky on a globe: a graticule, the ecliptic and stars, none of them real."""
    w, h, k = 1024, 512, 2
    image = Image.new("RGB", (w * k, h * k), (196, 172, 122))
    draw = ImageDraw.Draw(image)
    red = (134, 44, 30)
    for i in range(24):
        draw.line((i * w * k // 24, 0, i * w * k // 24, h * k), fill=(138, 116, 82), width=2 if i % 6 else 4)
    for i in range(1, 12):
        draw.line((0, i * h * k // 12, w * k, i * h * k // 12), fill=(138, 116, 82), width=2 if i != 6 else 7)
    path = [(x, h * k / 2 + h * k * 23.4 / 180 * math.sin(2 * math.pi * x / (w * k))) for x in range(0, w * k + 8, 8)]
    draw.line(path, fill=red, width=12)
    for _ in range(46):
        x, lat = random.uniform(0, w * k), math.asin(random.uniform(-0.92, 0.92))
        y = h * k / 2 - lat / math.pi * h * k
        stretch = 1 / math.cos(lat)
        chain = [(x, y)]
        for _ in range(random.randint(2, 5)):
            a = random.uniform(0, 2 * math.pi)
            chain.append((chain[-1][0] + 60 * stretch * math.cos(a), chain[-1][1] + 52 * math.sin(a)))
        draw.line(chain, fill=(74, 92, 96), width=6)
        for px, py in chain:
            r = random.choice((9, 11, 14, 20))
            star = [
                (px + (r if i % 2 == 0 else 0.42 * r) * stretch * math.sin(math.pi * i / 5), py - (r if i % 2 == 0 else 0.42 * r) * math.cos(math.pi * i / 5))
                for i in range(10)
            ]
            draw.polygon(star, fill=(30, 58, 84))
    image.resize((w, h), Image.LANCZOS).save("globe.jpg", quality=80)


def leaf_textures():
    k, w, h = 4, 64, 128
    shape = Image.new("L", (w * k, h * k), 0)
    outline = []
    for i in range(61):
        t = i / 60
        outline.append((t, 0.47 * math.sin(math.pi * t**0.8) ** 0.85))
    points = [(w * k * (0.5 + x), h * k * (1 - 0.02 - 0.96 * t)) for t, x in outline]
    points += [(w * k * (0.5 - x), h * k * (1 - 0.02 - 0.96 * t)) for t, x in reversed(outline)]
    ImageDraw.Draw(shape).polygon(points, fill=255)
    shape.resize((w, h), Image.LANCZOS).save("leaf-alpha.png", optimize=True)
    colour = Image.new("RGB", (w * k, h * k), (92, 132, 62))
    draw = ImageDraw.Draw(colour)
    for i in range(9):
        y = h * k * (0.95 - 0.1 * i)
        for s in (-1, 1):
            draw.line((w * k / 2, y, w * k / 2 + s * w * k * 0.46, y - h * k * 0.14), fill=(132, 164, 92), width=3)
    draw.line((w * k / 2, 0, w * k / 2, h * k), fill=(158, 184, 112), width=7)
    colour.resize((w, h), Image.LANCZOS).save("leaf.png", optimize=True)


def silk():
    """What a lamp's shade sends out: pleats, and a bulb behind them at a third of the height."""
    w, h = 384, 64
    y = np.linspace(1, 0, h)[:, None]
    x = np.arange(w)[None, :] / w
    pleats = 1 - 0.13 * np.abs(np.sin(48 * np.pi * x)) ** 3
    glow = 0.30 + 0.62 * np.exp(-(((y - 0.42) / 0.36) ** 2))
    strength = np.where((y < 0.045) | (y > 0.955), 0.12, glow) * pleats
    colour = np.array([1.0, 0.56, 0.22]) * strength[..., None] ** np.array([0.9, 1.15, 1.4])
    save("silk.png", np.where(colour < 0.0031308, 12.92 * colour, 1.055 * colour ** (1 / 2.4) - 0.055))


def drawing():
    """The double Gauss of lenses/ in section, drawn in ink, with two pencils of rays."""
    w, h, k = 900, 600, 2
    paper = Image.fromarray((255 * (np.array([0.93, 0.89, 0.79]) * (0.94 + 0.06 * smooth((h, w), (40, 40))[..., None]))).astype(np.uint8))
    paper = paper.resize((w * k, h * k), Image.BICUBIC)
    draw = ImageDraw.Draw(paper)
    ink, red = (40, 42, 60), (150, 50, 36)
    rows = [[float(v) for v in line.split()] for line in open("../../lenses/dgauss.50mm.dat") if line.strip() and line[0] != "#"]
    scale, x0, y0 = 15.0 * k, 250 * k, 290 * k
    z, places = 0.0, []
    for row in rows:
        places.append(z)
        z += row[1]

    def px(z, y):
        return (x0 + z * scale, y0 - y * scale)

    def sag(radius, y):
        return 0 if radius == 0 else radius - math.copysign(math.sqrt(radius**2 - y**2), radius)

    rims = []
    for (radius, _, index, diameter), z in zip(rows, places):
        a = diameter / 2
        rims.append((z, radius, a))
        if radius == 0:
            for s in (-1, 1):
                draw.line((*px(z, s * a), *px(z, s * (a + 4))), fill=ink, width=13)
            continue
        draw.line([px(z + sag(radius, a * t / 40), a * t / 40) for t in range(-40, 41)], fill=ink, width=9)
    for i in range(len(rows) - 1):
        if rows[i][2] > 1.0:
            (z, r, a), (y, q, b) = rims[i], rims[i + 1]
            for s in (-1, 1):
                draw.line((*px(z + sag(r, a), s * a), *px(y + sag(q, b), s * b)), fill=ink, width=9)
    draw.line((*px(-15, 0), *px(40, 0)), fill=ink, width=2)
    for slope in (0.0, 0.18):
        for y in (-8.5, -4.2, 0, 4.2, 8.5):
            u, n = slope, 1.0
            line = [px(-14, y - slope * 28)]
            height = y - slope * 14
            for i, ((radius, thickness, index, _), z) in enumerate(zip(rows, places)):
                line.append(px(z + sag(radius, min(abs(height), 8)) if radius else z, height))
                after = index if index else n
                if radius:
                    u = (n * u - height * (after - n) / radius) / after
                n = after
                if i + 1 < len(rows):
                    height += u * thickness
            line.append(px(places[-1] + 12, height + u * 12))
            draw.line(line, fill=red if slope else (70, 90, 120), width=4)
    font = ImageFont.load_default(size=40 * k // 2)
    draw.text((70 * k, 40 * k), "Doppelobjectiv, f = 50 mm", fill=ink, font=font)
    for i, row in enumerate(rows):
        draw.text((70 * k + 150 * k * (i % 5), (490 + 32 * (i // 5)) * k), f"r{i + 1} = {row[0]:.2f}", fill=ink, font=ImageFont.load_default(size=17 * k))
    draw.rectangle((30 * k, 24 * k, (w - 30) * k, (h - 24) * k), outline=ink, width=3)
    paper.resize((w, h), Image.LANCZOS).save("drawing.jpg", quality=72)


def ridges():
    """Normals of straight knurling: ridges along v."""
    n = 32
    x = np.arange(n) / n
    slope = 0.75 * np.cos(2 * np.pi * x)
    normal = np.stack([-slope, 0 * x, np.ones(n)], -1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    save("knurl.png", np.repeat((normal / 2 + 0.5)[None], 4, 0))


portrait_lens()
knob()
turnery()
cloth()
boxes()
shade()
books()
candles()
sprig()
wood()
leather()
patina()
engraving()
sky_globe()
leaf_textures()
silk()
drawing()
ridges()
