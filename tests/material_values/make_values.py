"""Writes values.txt: BSDF values (cosine included) of Mitsuba 3.9.1, variant scalar_rgb, for tests/agreement/materials.rs.

Mitsuba has no `ward`: its values follow from the formulas of the papers, in double precision.
Run with: pip install mitsuba==3.9.1 numpy; python make_values.py
"""

import math
import re
import pathlib

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")


def rgb(name, value):
    return f"<rgb name='{name}' value='{value}'/>"


def number(name, value):
    return f"<float name='{name}' value='{value}'/>"


def text(name, value):
    return f"<string name='{name}' value='{value}'/>"


def flag(name, value):
    return f"<boolean name='{name}' value='{value}'/>"


def bsdf(plugin, *parameters):
    return f"<bsdf type='{plugin}'>{''.join(parameters)}</bsdf>"


GGX = text("distribution", "ggx")
BASE = rgb("base_color", "0.8, 0.4, 0.2")
METAL = rgb("eta", "0.2, 0.9, 1.5") + rgb("k", "3.9, 2.4, 1.9")

MATERIALS = [
    bsdf("diffuse", rgb("reflectance", "0.8, 0.4, 0.2")),
    bsdf("roughconductor", text("material", "Au")),
    bsdf("roughconductor", GGX, number("alpha", 0.3), METAL),
    bsdf("roughconductor", GGX, number("alpha_u", 0.1), number("alpha_v", 0.4), METAL),
    bsdf("roughconductor", number("alpha_u", 0.5), number("alpha_v", 0.15), rgb("specular_reflectance", "0.9, 0.5, 0.1")),
    bsdf("roughdielectric"),
    bsdf("roughdielectric", GGX, number("alpha", 0.3), number("int_ior", 1.8)),
    bsdf("roughdielectric", GGX, number("alpha_u", 0.2), number("alpha_v", 0.6), number("int_ior", 1.2)),
    bsdf("roughdielectric", number("alpha", 0.4), number("int_ior", 1.0), number("ext_ior", 1.5)),
    bsdf("roughdielectric", number("alpha", 0.2), rgb("specular_reflectance", "0.9, 0.5, 0.1"),
         rgb("specular_transmittance", "0.2, 0.5, 0.8")),
    bsdf("plastic"),
    bsdf("plastic", rgb("diffuse_reflectance", "0.8, 0.4, 0.2"), flag("nonlinear", "true"), number("int_ior", 1.9)),
    bsdf("plastic", number("int_ior", 1.0), number("ext_ior", 1.3)),
    bsdf("roughplastic"),
    bsdf("roughplastic", GGX, number("alpha", 0.3), rgb("diffuse_reflectance", "0.8, 0.4, 0.2")),
    bsdf("roughplastic", number("alpha", 0.5), rgb("diffuse_reflectance", "0.8, 0.4, 0.2"), flag("nonlinear", "true"),
         number("int_ior", 1.9), rgb("specular_reflectance", "0.9, 0.5, 0.1")),
    bsdf("roughplastic", GGX, number("alpha", 0.05), number("int_ior", "1.3")),
    bsdf("blendbsdf", number("weight", 0.3), bsdf("diffuse", rgb("reflectance", "0.8, 0.4, 0.2")),
         bsdf("roughconductor", GGX, number("alpha", 0.3))),
    bsdf("blendbsdf", number("weight", 0.6), bsdf("roughdielectric", number("alpha", 0.3)), bsdf("plastic")),
    bsdf("mask", number("opacity", 0.3), bsdf("diffuse", rgb("reflectance", "0.8, 0.4, 0.2"))),
    bsdf("thindielectric"),
    bsdf("null"),
    bsdf("principled"),
    bsdf("principled", BASE, number("metallic", 1.0), number("roughness", 0.4)),
    bsdf("principled", BASE, number("metallic", 0.4), number("roughness", 0.6), number("anisotropic", 0.7),
         number("specular", 0.8), number("spec_tint", 0.5)),
    bsdf("principled", BASE, number("sheen", 0.7), number("sheen_tint", 0.6), number("flatness", 0.4),
         number("roughness", 0.8)),
    bsdf("principled", BASE, number("clearcoat", 0.9), number("clearcoat_gloss", 0.3)),
    bsdf("principled", BASE, number("spec_trans", 1.0), number("eta", 1.5), number("roughness", 0.6)),
    bsdf("principled", BASE, number("spec_trans", 0.6), number("eta", 1.3), number("metallic", 0.3),
         number("roughness", 0.5), number("spec_tint", 0.4), number("clearcoat", 0.5), number("sheen", 0.3)),
    bsdf("principledthin", BASE, number("flatness", 0.4), number("diff_trans", 0.7), number("sheen", 0.5),
         number("sheen_tint", 0.6)),
    bsdf("principledthin", BASE, number("spec_trans", 0.6), number("eta", 1.3), number("anisotropic", 0.6),
         number("spec_tint", 0.4), number("diff_trans", 1.4), number("roughness", 0.6), number("sheen", 0.3)),
    bsdf("principledthin", BASE, number("spec_trans", 1.0), number("eta", 0.7), number("roughness", 0.4),
         number("spec_tint", 0.3)),
    bsdf("ward"),
    bsdf("ward", text("variant", "balanced"), number("alpha_u", 0.1), number("alpha_v", 0.4),
         rgb("diffuse_reflectance", "0.3, 0.2, 0.1"), rgb("specular_reflectance", "0.3, 0.5, 0.7")),
    bsdf("ward", text("variant", "ward-duer"), number("alpha", 0.2)),
    bsdf("ward", text("variant", "ward"), number("alpha", 0.2)),
]


def normalized(vector):
    return np.array(vector) / np.linalg.norm(vector)


def pairs(random):
    """Where the path came from and where it goes: near the mirror direction, near refraction, and anywhere."""
    for side in (1, -1):
        for cosine in (0.95, 0.6, 0.25):
            azimuth = random.uniform(0, 2 * math.pi)
            sine = math.sqrt(1 - cosine * cosine)
            came = np.array([sine * math.cos(azimuth), sine * math.sin(azimuth), side * cosine])
            normal = normalized([*random.normal(0, 0.08, 2), 1])
            yield came, 2 * came.dot(normal) * normal - came
            yield came, normalized(-came + [*random.normal(0, 0.2, 2), -0.5 * side])
            yield came, normalized(random.normal(0, 1, 3))


def single(vector):
    """As single precision has it, so that both sides start from the same numbers."""
    return np.array(vector, dtype=np.float32).astype(float)


def ward_value(material, came, goes):
    def find(name, default):
        found = re.search(f"name='{name}' value='([^']*)'", material)
        return np.array([float(part) for part in found.group(1).split(",")]) if found else np.array(default)

    variant = re.search("name='variant' value='([^']*)'", material)
    alpha = find("alpha", [0.1])[0]
    alpha_u, alpha_v = find("alpha_u", [alpha])[0], find("alpha_v", [alpha])[0]
    if came[2] <= 0 or goes[2] <= 0:
        return np.zeros(3)
    half = came + goes
    slopes = math.exp(-((half[0] / alpha_u) ** 2 + (half[1] / alpha_v) ** 2) / half[2] ** 2) / (math.pi * alpha_u * alpha_v)
    glossy = {
        "ward": slopes / (4 * math.sqrt(came[2] * goes[2])),
        "ward-duer": slopes / (4 * came[2] * goes[2]),
        "balanced": slopes * half.dot(half) / half[2] ** 4,
    }[variant.group(1) if variant else "balanced"]
    matte = find("diffuse_reflectance", [0.5]) / math.pi
    return (matte + find("specular_reflectance", [0.2]) * glossy) * goes[2] * np.ones(3)


def mitsuba_value(material, mode, came, goes):
    context = mi.BSDFContext()
    context.mode = mode
    point = mi.SurfaceInteraction3f()
    point.wi = mi.Vector3f(*came)
    point.uv = [0.5, 0.5]
    return np.array(material.eval(context, point, mi.Vector3f(*goes))).reshape(3)


def main():
    random = np.random.default_rng(1)
    lines = ["# a material, then lines of: where the path came from, where it goes, value for radiance, for flux if it differs"]
    for written in MATERIALS:
        lines.append(written)
        is_ward = "'ward'" in written
        material = None if is_ward else mi.load_string(written.replace("<bsdf", "<bsdf version='3.0.0'", 1))
        for came, goes in pairs(random):
            came, goes = single(came), single(goes)
            modes = (mi.TransportMode.Radiance, mi.TransportMode.Importance)
            values = [ward_value(written, came, goes) if is_ward else mitsuba_value(material, mode, came, goes) for mode in modes]
            numbers = [*came, *goes, *values[0], *([] if (values[0] == values[1]).all() else values[1])]
            lines.append(" ".join(f"{number:.9g}" for number in numbers))
    pathlib.Path(__file__).with_name("values.txt").write_text("\n".join(lines) + "\n")


main()
