"""Makes the arm mirrored into a whole, to compare a half model with half of a whole one.

    python3 make_mirrored.py [--curves]

arm-mirrored.ecorche: two arms on a trunk, symmetric across Y = 0, muscles of both sides and two that cross the plane.
arm-half.ecorche: the same skin and bones with the plane as a symmetry plane; the crossing muscles end on it.
Run make_arm.py first. The skin is symmetric to the last digit: one half is meshed, the other mirrored.
"""
import sys

import numpy as np
import trimesh
from fast_simplification import simplify
from skimage.measure import marching_cubes

import arm_bones as ab
import arm_skin
import make_arm as ma
from arm_muscles import MUSCLES, Head, Muscle, s, u, w

sys.path.insert(0, str(ma.HERE.parent / "common"))
import implicit as im  # noqa: E402
import meshes as ms  # noqa: E402
import project as pj  # noqa: E402

BOX = (-160, 0, -800), (280, 460, 220)  # of one half [mm]
MEDIAN = (np.zeros(3), np.array([0.0, 1.0, 0.0]))

# Their second point lies straight beside the first: the curve crosses the plane at a right angle, so that the spline
# that ends on the plane is half of the one that goes through.
CROSSING = [
    Muscle("pectoralis_major", "trunk", 2, [
        Head("upper part", ("median", w(101, 0, -62)), [w(101, 24, -62), w(84, 84, -52), w(40, 150, -30)],
             ("humerus", u(18, 14, 52))),
        Head("lower part", ("median", w(101, 0, -118)), [w(101, 24, -118), w(80, 90, -92), w(48, 150, -62), w(41, 188, -62)],
             ("humerus", u(17, 13, 66))),
    ], value=0.6),
    Muscle("trapezius", "trunk", 2, [
        Head("upper part", ("median", w(-88, 0, 18)), [w(-88, 24, 18), w(-86, 62, 34)], ("scapula", s(-40, 28, 24))),
        Head("lower part", ("median", w(-92, 0, -40)), [w(-92, 24, -40), w(-92, 58, -14)], ("scapula", s(-88, 12, 18))),
    ], value=0.5),
]


def mirrored(mesh):
    return trimesh.Trimesh(np.asarray(mesh.vertices) * [1, -1, 1], np.asarray(mesh.faces)[:, ::-1], process=False)


def weld_halves(vertices, faces):
    """A half with its rim at y = 0, and its mirror image, as one closed mesh."""
    vertices = np.array(vertices)
    vertices[np.abs(vertices[:, 1]) < 1e-6, 1] = 0.0
    rim = vertices[:, 1] == 0.0
    other = np.where(rim, np.arange(len(vertices)), 0)
    other[~rim] = len(vertices) + np.arange((~rim).sum())
    return trimesh.Trimesh(np.vstack([vertices, vertices[~rim] * [1, -1, 1]]),
                           np.vstack([faces, other[faces][:, ::-1]]), process=False)


def symmetric_mesh(shape, low, high, step, triangles):
    """Like implicit.mesh_of for a shape that is symmetric across Y = 0; `triangles` counts both halves."""
    low = [low[0], -12 * step, low[2]]
    field, corner = im.sample(shape, low, high, step, border=False)
    first = int(round(-corner[1] / step))
    assert abs(corner[1] + first * step) < 1e-9, "a layer of the grid has to lie on the plane"
    vertices, faces, _, _ = marching_cubes(field[:, first:], 0.0, spacing=(step,) * 3)
    vertices = vertices + [corner[0], 0, corner[2]]
    both = weld_halves(vertices, faces[:, ::-1])
    trimesh.smoothing.filter_taubin(both, lamb=0.5, nu=0.52, iterations=6)
    half = np.array(both.vertices[: len(vertices)])
    half[vertices[:, 1] < 1e-6, 1] = 0.0
    # Thinning may join two vertices of the rim across it, which four faces would share: then thin a little less
    for more in range(8):
        count = int(triangles * (1 + 0.06 * more) / 2)
        thin = simplify(half, both.faces[: len(faces)], target_count=count, preserve_border=True)
        mesh = weld_halves(*thin)
        if mesh.is_watertight and len(ms.crossings(mesh)) == 0:
            break
    if mesh.volume < 0:
        mesh.invert()
    return ma.metres(mesh)


def make_meshes(left):
    thorax = symmetric_mesh(arm_skin.thorax(), *BOX, 3.0, 3000)
    skin = symmetric_mesh(arm_skin.whole(), *BOX, 2.5, 22000)
    right = {f"{name}_right": mirrored(mesh) for name, mesh in left.items()}
    ms.verify({**left, "thorax": thorax}, skin)
    ms.write_obj(ma.HERE / "mirrored-bones.obj", {**right, "thorax": thorax},
                 "Bones of the right arm and a thorax, made by make_mirrored.py; metres")
    ms.write_obj(ma.HERE / "mirrored-skin.obj", {"skin": skin}, "Two arms on a trunk, made by make_mirrored.py; metres")


def mirror_tissue(entry):
    """The same muscle on the right."""
    copy = dict(entry, name=entry["name"].replace("_left", "_right"), side="right", curves=[])
    if "anisotropy" in entry:
        copy["anisotropy"] = dict(entry["anisotropy"], rotation=-entry["anisotropy"]["rotation"])
    for curve in entry["curves"]:
        points = [dict(p, at=[p["at"][0], -p["at"][1], p["at"][2]]) for p in curve["points"]]
        ends = {k: dict(curve[k], name=curve[k]["name"] + "_right") for k in ("start", "end")}
        copy["curves"].append(dict(curve, points=points, **ends))
    return copy


def whole_from_half(entry):
    """A crossing muscle from the right bone through the plane to the left one."""
    curves = []
    for curve in entry["curves"]:
        points = curve["points"]
        right = [dict(p, at=[p["at"][0], -p["at"][1], p["at"][2]]) for p in points[:0:-1]]
        bone = curve["end"]["name"]
        curves.append(dict(curve, points=right + points, start={"on": "bone", "name": f"{bone}_right"}))
    return dict(entry, side="median", curves=curves)


def main():
    left = ma.read_parts(ma.HERE / "bones.obj")
    if "--curves" not in sys.argv:
        make_meshes(left)
    added = ma.read_parts(ma.HERE / "mirrored-bones.obj")
    skin = ma.read_parts(ma.HERE / "mirrored-skin.obj")["skin"]

    placed = ma.place_curves(MUSCLES + CROSSING, {**left, "thorax": added["thorax"]}, skin, limits=[MEDIAN])
    for (_, head), points in zip(placed[0], placed[1]):
        if head.start[0] == "median":
            points[1] = [points[0][0], points[1][1], points[0][2]]
    fitted = ma.factors()
    one_side = [dict(ma.tissue(m, placed, fitted.get(m.name, m.value)), name=f"{m.name}_left") for m in MUSCLES]
    crossing = [ma.tissue(m, placed, fitted.get(m.name, m.value)) for m in CROSSING]

    project = {
        "schema": 1,
        "name": "two arms on a trunk",
        "unit": "m",
        "skin": {"file": "mirrored-skin.obj"},
        "bones": [{"name": name, "file": "bones.obj", "part": name} for name in left]
        + [{"name": name, "file": "mirrored-bones.obj", "part": name} for name in added],
        "settings": {"fat": 0.3, "core_radius": 0.001, "tets": 400000},
    }
    whole = one_side + [mirror_tissue(entry) for entry in one_side] + [whole_from_half(entry) for entry in crossing]
    pj.save(ma.HERE / "arm-mirrored.ecorche", {**project, "tissues": whole})
    plane = {"name": "median", "kind": "symmetry", "point": [0, 0, 0], "normal": [0, 1, 0]}
    half = {
        **{k: project[k] for k in ("schema", "name", "unit", "skin", "bones")},
        "cut_planes": [plane],
        "settings": {**project["settings"], "tets": 200000},
        "tissues": one_side + crossing,
    }
    pj.save(ma.HERE / "arm-half.ecorche", {**half, "name": "left half of two arms on a trunk"})
    print(f"{len(whole)} muscles in the whole, {len(half['tissues'])} in the half")


if __name__ == "__main__":
    main()
