"""Writes reference_volumes.csv: the artist's muscles inside the kept region, to fit tissue values to.

Reads the muscles from ECORCHE_DATA (see make_hind_limb.py). They overlap one another and dip into bones, so their
volumes are a guide, not a truth; fasciae and tendons that are files of their own are left out.
"""
import csv
import sys

import manifold3d
import numpy as np
import trimesh

import make_hind_limb as mh
from muscle_list import MUSCLES


def kept_volume(file):
    """Volume in front of the cut planes [cm³]."""
    mesh = trimesh.load(mh.DATA / "muscles" / file)
    solid = manifold3d.Manifold(manifold3d.Mesh(np.asarray(mesh.vertices, np.float32), np.asarray(mesh.faces, np.uint32)))
    if solid.status() != manifold3d.Error.NoError:
        sys.exit(f"{file}: {solid.status()}")
    for point, normal in mh.PLANES.values():
        solid = solid.trim_by_plane(normal, float(np.dot(point, normal)))
    return 1e6 * solid.volume()


def main():
    with open(mh.HERE / "reference_volumes.csv", "w", newline="") as out:
        table = csv.writer(out, lineterminator="\n")
        table.writerow(["muscle", "volume_cm3", "files"])
        for muscle in MUSCLES:
            files = sorted({head.file for head in muscle.heads if head.file})
            if files:
                table.writerow([muscle.name, f"{sum(map(kept_volume, files)):.2f}", " ".join(files)])


if __name__ == "__main__":
    main()
