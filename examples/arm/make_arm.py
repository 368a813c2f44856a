"""Makes the arm: skin.obj, bones.obj and arm.ecorche.

    python3 make_arm.py            everything
    python3 make_arm.py --curves   only the project files, on the meshes that are there

Needs ../requirements.txt. Every mesh is checked before it is written: closed, manifold, outward, free of
self-intersections, bones at least 1 mm apart and 2 mm under the skin.
"""
import json
import sys
from pathlib import Path

import numpy as np
import trimesh

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "common"))
import curves as cv  # noqa: E402
import implicit as im  # noqa: E402
import meshes as ms  # noqa: E402
import project as pj  # noqa: E402
import arm_bones as ab  # noqa: E402
import arm_skin  # noqa: E402
from arm_muscles import MUSCLES  # noqa: E402


LEAST = 0.25  # a curve of a lower value would lose its place to a strong neighbour


def metres(mesh):
    mesh.apply_scale(0.001)
    return ms.rounded(mesh)


def make_meshes():
    bones = {}
    for name, shape in ab.shapes().items():
        bones[name] = metres(im.mesh_of(shape, *ab.BOX, 1.0, ab.TRIANGLES[name]))
        print(f"  {name}: {len(bones[name].faces)} triangles, {1e6 * bones[name].volume:.0f} cm³", flush=True)
    skin = metres(im.mesh_of(arm_skin.single(), *ab.BOX, 2.0, 15000))
    ms.verify(bones, skin)
    ms.write_obj(HERE / "bones.obj", bones, "Bones of a left arm, made by make_arm.py; metres")
    ms.write_obj(HERE / "skin.obj", {"skin": skin}, "Skin of a left arm, made by make_arm.py; metres")


def read_parts(file):
    """The parts of an OBJ that write_obj wrote."""
    parts, name, vertices, faces, first = {}, None, [], [], 0
    for line in file.read_text().splitlines() + ["o "]:
        word, *rest = line.split() or [""]
        if word == "o":
            if name:
                parts[name] = trimesh.Trimesh(vertices, np.array(faces) - 1 - first, process=False)
                first += len(vertices)
            name, vertices, faces = " ".join(rest), [], []
        elif word == "v":
            vertices.append([float(c) for c in rest])
        elif word == "f":
            faces.append([int(c) for c in rest])
    return parts


def default_values(count):
    """A belly between two tendons."""
    x = np.linspace(-1, 1, count)
    return 1.0 - 0.4 * x**4


def place_curves(muscles, bones, skin, limits=()):
    """Control points, values and anchors of every head, clear of bones, skin and one another."""
    heads = [(muscle, head) for muscle in muscles for head in muscle.heads]
    surfaces = {name: cv.Surface(mesh.vertices, mesh.faces) for name, mesh in bones.items()}
    points, values, anchors = [], [], []
    for _, head in heads:
        anchors.append((head.start[0], head.end[0]))
        at = np.array([head.start[1], *head.course, head.end[1]], float) / 1000
        for k in (0, -1):
            if anchors[-1][k] in surfaces:
                at[k] = surfaces[anchors[-1][k]].project(at[k])
        points.append(at)
        values.append(np.array(head.values) if head.values else default_values(len(at)))
    around, skin = cv.Bones(surfaces), cv.Surface(skin.vertices, skin.faces)
    cv.spread_ends(points, anchors, surfaces)
    same = [muscle.name for muscle, _ in heads]
    for _ in range(4):
        points = cv.relax(points, around, skin, same=same, limits=limits)
        if not any(cv.refine(points, values, around, skin)):
            break
    points = cv.relax(points, around, skin, same=same, limits=limits)
    for complaint in cv.check(points, [f"{m.name}/{h.name}" for m, h in heads], around, skin, limits=limits):
        print("  !", complaint)
    return heads, points, values, anchors


def tissue(muscle, placed, factor, side="left"):
    """The muscle as an entry of the project file."""
    entry = {"name": muscle.name, "kind": "muscle", "side": side, "group": muscle.group, "layer": muscle.layer}
    if muscle.anisotropy:
        entry["anisotropy"] = dict(zip(("lambda2", "lambda3", "rotation"), muscle.anisotropy))
    entry["curves"] = [
        pj.curve(head.name, at, np.maximum(LEAST, factor * value), *[("plane" if name == "median" else "bone", name) for name in ends])
        for (owner, head), at, value, ends in zip(*placed) if owner is muscle
    ]
    return entry


def factors():
    """The factor on each muscle's tissue values that fit_values.py found."""
    fitted = HERE / "values.json"
    return json.loads(fitted.read_text()) if fitted.exists() else {}


def main():
    if "--curves" not in sys.argv:
        make_meshes()
    bones, skin = read_parts(HERE / "bones.obj"), read_parts(HERE / "skin.obj")["skin"]
    placed, fitted = place_curves(MUSCLES, bones, skin), factors()
    tissues = [tissue(muscle, placed, fitted.get(muscle.name, muscle.value)) for muscle in MUSCLES]
    pj.save(HERE / "arm.ecorche", {
        "schema": 1,
        "name": "left arm",
        "unit": "m",
        "skin": {"file": "skin.obj"},
        "bones": [{"name": name, "file": "bones.obj", "part": name} for name in bones],
        "settings": {"fat": 0.3, "core_radius": 0.001, "tets": 200000},
        "tissues": tissues,
    })
    print(f"{len(tissues)} muscles, {sum(len(t['curves']) for t in tissues)} curves")


if __name__ == "__main__":
    main()
