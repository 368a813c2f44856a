"""Makes the four architectures of [ABLSJ21, figure of muscle types]: parallel, fusiform, triangular, unipennate.

One muscle between two bones in an egg of skin each; the curves alone make the difference. Millimetres; X runs from
origin to insertion.
"""
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "common"))
import curves as cv  # noqa: E402
import implicit as im  # noqa: E402
import meshes as ms  # noqa: E402
import project as pj  # noqa: E402

WORLD = im.Frame([0, 0, 0], np.eye(3))
BOX = (-140, -110, -70), (140, 110, 70)


def egg(*radii):
    return im.ellipsoid(WORLD, (0, 0, 0), radii)


def rod(a, b, radius):
    return im.capsule(a, b, radius, radius)


# name: skin, origin, insertion, curves as (start, end), tissue values along each curve
ARCHITECTURES = {
    # Fascicles side by side, all of one length: a strap
    "parallel": (
        egg(92, 50, 30),
        im.ellipsoid(WORLD, (-64, 0, 0), (7, 24, 9)), im.ellipsoid(WORLD, (64, 0, 0), (7, 24, 9)),
        [((-58, y, 0), (58, y, 0)) for y in (-14, 0, 14)], (1.0, 1.0, 1.0, 1.0),
    ),
    # A belly between two tendons
    "fusiform": (
        egg(86, 34, 34),
        im.ball((-68, 0, 0), 8), im.ball((68, 0, 0), 8),
        [((-60, 0, 0), (60, 0, 0))], (0.25, 1.1, 2.0, 1.1, 0.25),
    ),
    # A broad origin and one point of insertion
    "triangular": (
        egg(82, 66, 26),
        rod((-44, -40, 0), (-44, 40, 0), 6), im.ball((64, 0, 0), 9),
        [((-38, y, 0), (58, 0.12 * y, 0)) for y in (-34, -17, 0, 17, 34)], (0.8, 0.75, 0.65, 0.4),
    ),
    # Fascicles run at an angle from a long bone to a long tendon beside it
    "unipennate": (
        egg(104, 42, 28),
        rod((-78, 15, 0), (32, 15, 0), 4), rod((-32, -15, 0), (78, -15, 0), 4),
        [((x, 15, 0), (x + 42, -15, 0)) for x in (-73, -57, -41, -25, -9, 7, 23)], (0.7, 0.7, 0.7),
    ),
}


def make(name, skin, origin, insertion, ends, values):
    parts = {"skin": im.mesh_of(skin, *BOX, 2.0, 2400)}
    parts |= {bone: im.mesh_of(shape, *BOX, 0.8, 700) for bone, shape in (("origin", origin), ("insertion", insertion))}
    for part, mesh in parts.items():
        mesh.apply_scale(0.001)
        parts[part] = ms.rounded(mesh)
    print(name)
    ms.verify({k: v for k, v in parts.items() if k != "skin"}, parts["skin"])
    ms.write_obj(HERE / f"{name}.obj", parts, f"Skin and two bones for a {name} muscle, made by make_architectures.py")

    surfaces = {bone: cv.Surface(parts[bone].vertices, parts[bone].faces) for bone in ("origin", "insertion")}
    curves = []
    for k, (start, end) in enumerate(ends):
        start, end = np.array(start) / 1000, np.array(end) / 1000
        along = 0.012 * (end - start) / np.linalg.norm(end - start)  # leave each bone towards the other
        start, end = surfaces["origin"].project(start + along), surfaces["insertion"].project(end - along)
        points = start + np.linspace(0, 1, len(values))[:, None] * (end - start)
        label = "" if len(ends) == 1 else f"fascicle {k + 1}"
        curves.append(pj.curve(label, points, values, ("bone", "origin"), ("bone", "insertion")))
    pj.save(HERE / f"{name}.ecorche", {
        "schema": 1,
        "name": f"{name} muscle",
        "unit": "m",
        "skin": {"file": f"{name}.obj", "part": "skin"},
        "bones": [{"name": bone, "file": f"{name}.obj", "part": bone} for bone in surfaces],
        "settings": {"fat": 0.3, "core_radius": 0.001, "tets": 80000},
        "tissues": [{"name": name, "kind": "muscle", "curves": curves}],
    })


def main():
    for name, design in ARCHITECTURES.items():
        make(name, *design)


if __name__ == "__main__":
    main()
