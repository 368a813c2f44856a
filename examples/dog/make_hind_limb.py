"""Makes hind-limb.ecorche: the muscles of a dog's left hind limb as curves.

Reads the artist's muscles and attachment sites (ECORCHE_DATA, default ../shared/data beside the project), which are
not part of the project: what is written here are coordinates derived from them. Run after script/fetch-dog.

    python3 make_hind_limb.py

values.json holds one factor on each muscle's tissue values (common/fit_values.py finds them); without it all muscles
start alike.
"""
import csv
import json
import os
import pathlib
import re
import sys

import numpy as np
import trimesh

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "common"))
import curves as cv  # noqa: E402
import project as pj  # noqa: E402
from muscle_list import MUSCLES  # noqa: E402
from sections import Sections  # noqa: E402

DATA = pathlib.Path(os.environ.get("ECORCHE_DATA", HERE.parents[2] / "shared" / "data")) / "dog"
EDGE = -0.2  # the region of interest ends here [m]
LEAST = 0.25  # a curve of a lower value would lose its place to a strong neighbour
PLANES = {"median": ((0, 0, 0), (0, 1, 0)), "edge": ((EDGE, 0, 0), (-1, 0, 0))}


def bone_name(file):
    return file.stem.removeprefix("BONE")


BONE_WORDS = {
    "Femoris_L": "femur", "Femoris_fabellae_L_1": "fabella_lateral", "Femoris_fabellae_L_2": "fabella_medial",
    "Patella_L": "patella", "Tibia_L": "tibia", "Fibula_L": "fibula", "Calcaneal_tuber_L": "calcaneus",
    "Tibial_tarsal_L": "talus", "Tarsus_central_L": "central_tarsal", "Pelvis": "pelvis", "Sacrum": "sacrum",
}


def clean_name(bone):
    """The bone's name as an anatomist writes it; hind digits of a dog are II to V."""
    if bone in BONE_WORDS:
        return BONE_WORDS[bone]
    for pattern, word in ((r"Ca_(\d+)", "caudal"), (r"L_(\d+)", "lumbar")):
        if match := re.fullmatch(pattern, bone):
            return f"{word}_{match[1]}"
    if match := re.fullmatch(r"Tarsus_L_(I|II|III|IV)", bone):
        return f"tarsal_{('I', 'II', 'III', 'IV').index(match[1]) + 1}"
    for pattern, word in ((r"Metatarsi_L_(\d)", "metatarsal"), (r"Phalanges_B_L_(\d)", "proximal_phalanx"),
                          (r"Phalanges_B_2_L_(\d)", "middle_phalanx"), (r"Phalanges_B_3_L_(\d)", "distal_phalanx")):
        if match := re.fullmatch(pattern, bone):
            return f"{word}_{int(match[1]) + 1}"
    raise SystemExit(f"no anatomical name for the bone {bone}")


def load_bones():
    """Bones that reach into the kept region, by name."""
    bones = {}
    for file in sorted((DATA / "bones").glob("BONE*.stl")):
        mesh = trimesh.load(file)
        if mesh.bounds[0, 0] < EDGE and mesh.bounds[1, 1] > 0:
            bones[bone_name(file)] = cv.Surface(mesh.vertices, mesh.faces)
    return bones


def load_sites():
    """(muscle file, bone name in the site) -> centroids."""
    sites = {}
    with open(DATA / "attachment_sites.csv", newline="") as rows:
        for row in csv.DictReader(rows):
            key = (row["muscle_file"], row["bone_name_in_site"])
            sites.setdefault(key, []).append(np.array([float(row[k]) for k in ("cx", "cy", "cz")]))
    return sites


def end_point(spec, file, sites):
    """Where an end lies before it is projected: the site's centroid, or the coordinates given in the list."""
    if spec.at is not None:
        return np.array(spec.at)
    return sites[(file, spec.site)][spec.which]


def crop(mesh, behind):
    """The faces in front of X = behind."""
    kept = mesh.submesh([np.all(mesh.vertices[mesh.faces][:, :, 0] > behind, axis=1)], append=True)
    return max(kept.split(only_watertight=False), key=lambda part: len(part.faces))


def trim_to_plane(path, radii):
    """The part of a path that lies in the kept region, beginning exactly on the edge."""
    first = int(np.argmax(path[:, 0] < EDGE - 1e-4))
    if first == 0:
        begin = path[0] + np.array([EDGE - path[0][0], 0, 0])
        return np.vstack([begin, path]), np.concatenate([[radii[0]], radii])
    share = (EDGE - path[first - 1, 0]) / (path[first, 0] - path[first - 1, 0])
    begin = path[first - 1] + share * (path[first] - path[first - 1])
    return np.vstack([begin, path[first:]]), np.concatenate([[radii[first]], radii[first:]])


def first_guess(muscle, head, sites, bones):
    """Control points, values and the ends' bones of one head, before relaxation."""
    if not head.file:
        return np.array(head.path), np.ones(len(head.path))
    mesh = trimesh.load(DATA / "muscles" / head.file)
    if head.crop is not None:
        mesh = crop(mesh, head.crop)
    table = head.sites or head.file
    together = [h for h in muscle.heads if h.file == head.file]
    starts = [end_point(h.start, table, sites) for h in together if h.start.bone != "edge"]
    ends = [end_point(h.end, table, sites) for h in together]
    if not starts:
        starts = [mesh.vertices[np.argmax(mesh.vertices[:, 0])]]
    sections = Sections(mesh, starts, ends)
    path, radii = sections.path(head.strip, head.strips)
    if head.via:
        keep = np.array([0.12 < t < 0.88 for t in np.linspace(0.06, 0.94, len(path))])
        path[keep] += np.array(head.via)

    end = end_point(head.end, table, sites)
    if head.end.bone in bones:
        end = bones[head.end.bone].project(end if head.strips == 1 else 0.6 * end + 0.4 * path[-1])
    keep = np.linalg.norm(path - end, axis=1) > 0.006
    path, radii = path[keep], radii[keep]
    if head.start.bone == "edge":
        path, radii = trim_to_plane(path, radii)
    else:
        start = end_point(head.start, table, sites)
        start = bones[head.start.bone].project(start if head.strips == 1 else 0.4 * start + 0.6 * path[0])
        keep = np.linalg.norm(path - start, axis=1) > 0.006
        path, radii = np.vstack([start, path[keep]]), np.concatenate([radii[keep][:1], radii[keep]])
    path, radii = np.vstack([path, end]), np.append(radii, radii[-1])

    s = cv.arc_length(path)
    points = cv.resample(path, head.points)
    radius = np.interp(np.linspace(0, s[-1], head.points), s, radii)
    if head.path:
        points = np.vstack([path[0], head.path, path[-1]])
        nearest = np.linalg.norm(points[:, None] - path[None], axis=2).argmin(1)
        radius = radii[nearest]
    values = np.clip(radius / radius.max(), 0.45, 1.0)
    values[0], values[-1] = np.clip(values[0], 0.45, 0.8), np.clip(values[-1], 0.45, 0.8)
    if head.belly:
        values = np.interp(cv.arc_length(points) / cv.arc_length(points)[-1], *zip(*head.belly))
    return points, values


def anchor(name, bones):
    """What an end sits on, as the project file says it; none where it is free."""
    if name == "free":
        return None
    if name in bones:
        return "bone", clean_name(name)
    return "plane" if name in PLANES else "tissue", name


def main():
    fitted = HERE / "values.json"
    factors = json.loads(fitted.read_text()) if fitted.exists() else {}
    bones, sites = load_bones(), load_sites()
    body = trimesh.load(DATA / "SKINbody.stl")
    skin = cv.Surface(body.vertices, body.faces)

    heads = [(muscle, head) for muscle in MUSCLES for head in muscle.heads]
    guesses = [first_guess(muscle, head, sites, bones) for muscle, head in heads]
    guesses = [cv.unfold(*g) for g in guesses]
    points = [g[0] for g in guesses]
    anchors = [(head.start.bone, head.end.bone) for _, head in heads]
    cv.spread_ends(points, anchors, bones)
    # Sheets keep their own curves apart by construction; heads of one muscle may meet
    around, values = cv.Bones(bones), [g[1] for g in guesses]
    for _ in range(4):
        points = cv.relax(points, around, skin, same=[m.name for m, _ in heads], limits=PLANES.values())
        if not any(cv.refine(points, values, around, skin)):
            break
    for _ in range(3):
        unfolded = [cv.unfold(p, v) for p, v in zip(points, values)]
        points, values = [u[0] for u in unfolded], [u[1] for u in unfolded]
        points = cv.relax(points, around, skin, same=[m.name for m, _ in heads], limits=PLANES.values())

    names = [f"{m.name}/{h.name}" for m, h in heads]
    for complaint in cv.check(points, names, around, skin, limits=PLANES.values()):
        print("  !", complaint)

    tissues = []
    for muscle in MUSCLES:
        factor = factors.get(muscle.name, muscle.value)
        entry = {"name": muscle.name, "kind": muscle.kind, "side": "left", "group": muscle.group, "layer": muscle.layer}
        if muscle.anisotropy:
            entry["anisotropy"] = dict(zip(("lambda2", "lambda3", "rotation"), muscle.anisotropy))
        if muscle.kind != "muscle":
            del entry["side"]
        entry["curves"] = []
        for (owner, head), at, value in zip(heads, points, values):
            if owner is not muscle:
                continue
            ends = [anchor(b, bones) for b in (head.start.bone, head.end.bone)]
            entry["curves"].append(pj.curve(head.name, at, np.maximum(LEAST, factor * value), *ends))
        tissues.append(entry)

    pj.save(HERE / "hind-limb.ecorche", {
        "schema": 1,
        "name": "dog, left hind limb",
        "unit": "m",
        "skin": {"file": "mesh/SKINbody.stl"},
        "bones": [{"name": clean_name(name), "file": f"mesh/BONE{name}.stl"} for name in bones],
        "cut_planes": [
            {"name": "median", "kind": "symmetry", "point": [0, 0, 0], "normal": [0, 1, 0]},
            {"name": "edge", "kind": "region", "point": [EDGE, 0, 0], "normal": [-1, 0, 0]},
        ],
        "settings": {"fat": 0.3, "core_radius": 0.0015, "tets": 200000},
        "tissues": tissues,
    })
    print(f"{len(MUSCLES)} tissues, {len(heads)} curves")


if __name__ == "__main__":
    main()
