"""Measures an output folder with other people's readers (meshio, vtk) and arithmetic of its own; prints JSON.

  measure.py FOLDER             tets, surfaces, volumes, fibres
  measure.py FOLDER deviations  how far skin and bones have moved, share of the skin's diagonal

Nothing of ours is asked but model.json, which says what the numbers in the files stand for. The test that reads the
JSON knows what it must say.
"""

import json
import sys
from fractions import Fraction

import meshio
import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy

folder = sys.argv[1]
model = json.load(open(folder + "/model.json"))


# --- three readings of the same tets


def with_vtk():
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(folder + "/anatomy.vtu")
    reader.Update()
    grid = reader.GetOutput()
    return {
        "points": vtk_to_numpy(grid.GetPoints().GetData()).astype(float),
        "tets": vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4).astype(np.int64),
        "tissue": vtk_to_numpy(grid.GetCellData().GetArray("tissue")).astype(np.int64),
        "fiber": vtk_to_numpy(grid.GetCellData().GetArray("fiber")).astype(float),
        "kinds": {grid.GetCellType(0), grid.GetCellType(grid.GetNumberOfCells() - 1)},
    }


def with_meshio_vtu():
    m = meshio.read(folder + "/anatomy.vtu")
    return {"points": m.points, "tets": m.cells_dict["tetra"], "tissue": np.ravel(m.cell_data["tissue"][0])}


def with_meshio_medit():
    m = meshio.read(folder + "/anatomy.mesh")
    reference = dict(zip([c.type for c in m.cells], m.cell_data["medit:ref"]))
    return {
        "points": m.points,
        "tets": m.cells_dict["tetra"],
        "tissue": np.ravel(reference["tetra"]),
        "triangles": m.cells_dict["triangle"],
        "reference": np.ravel(reference["triangle"]),
    }


def differ(a, b):
    same = len(a["points"]) == len(b["points"]) and len(a["tets"]) == len(b["tets"])
    if not same:
        return 1
    return int((a["points"] != b["points"]).sum() + (a["tets"] != b["tets"]).sum() + (a["tissue"] != b["tissue"]).sum())


# --- tets


def exact_sign(corners):
    a, b, c, d = ([Fraction(float(x)) for x in p] for p in corners)
    u, v, w = ([q[k] - a[k] for k in range(3)] for q in (b, c, d))
    det = (u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0]))
    return (det > 0) - (det < 0)


def determinants(points, tets):
    """Six times the volumes, and how far rounding may have moved each."""
    a = points[tets[:, 0]]
    u, v, w = (points[tets[:, k]] - a for k in (1, 2, 3))
    det = np.einsum("ij,ij->i", np.cross(u, v), w)
    size = np.abs(points).max()
    lengths = [np.abs(e).sum(axis=1) + 4 * size * 2.0**-52 for e in (u, v, w)]
    largest = np.maximum(np.maximum(lengths[0], lengths[1]), lengths[2])
    return det, 64 * 2.0**-53 * (lengths[0] * lengths[1] * lengths[2] + size * largest * largest)


def not_positive(points, tets, det, bound):
    bad = int((det < -bound).sum())
    return bad + sum(exact_sign(points[tets[t]]) <= 0 for t in np.flatnonzero(np.abs(det) <= bound))


# Opposite corner k; seen from outside a positive tet, counter-clockwise
FACES = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]


def keys(rows, count):
    """One number for each set of corners, whatever their order."""
    s = np.sort(rows, axis=1)
    key = s[:, 0]
    for k in range(1, s.shape[1]):
        key = key * count + s[:, k]
    return key


def is_even(rows):
    """Whether sorting a triangle's corners takes an even number of swaps."""
    a, b, c = rows.T
    return ((a > b).astype(int) + (a > c) + (b > c)) % 2 == 0


class Components:
    """Connected components by hooking roots to smaller ones."""

    def __init__(self, count, a, b):
        parent = np.arange(count)
        while True:
            pa, pb = parent[a], parent[b]
            apart = pa != pb
            if not apart.any():
                break
            a, b = a[apart], b[apart]
            parent[np.maximum(pa, pb)[apart]] = np.minimum(pa, pb)[apart]
            while True:
                higher = parent[parent]
                if (higher == parent).all():
                    break
                parent = higher
        self.root = parent

    def count(self, of):
        return len(np.unique(self.root[of]))


def faces_of(points, tets, tissue):
    """Every face once: its one or two tets, and triangles that look out of the first."""
    n = len(points)
    corner = np.concatenate([tets[:, f] for f in FACES])
    tet = np.tile(np.arange(len(tets)), 4)
    key = keys(corner, n)
    order = np.argsort(key, kind="stable")
    key, corner, tet = key[order], corner[order], tet[order]
    begin = np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]]))
    uses = np.diff(np.concatenate([begin, [len(key)]]))
    pairs = begin[uses == 2]
    return {
        "most": int(uses.max()),
        "same_side": int((is_even(corner[pairs]) == is_even(corner[pairs + 1])).sum()),
        "boundary": corner[begin[uses == 1]],
        "boundary_tet": tet[begin[uses == 1]],
        "inner": corner[pairs],
        "inner_tets": np.stack([tet[pairs], tet[pairs + 1]], axis=1),
    }


def muscle_surfaces(faces, tissue):
    """Triangles around every tissue but fat, those between two muscles twice: tissue and corners, looking out."""
    a, b = tissue[faces["inner_tets"]].T
    owner = [tissue[faces["boundary_tet"]], a[a != b], b[a != b]]
    corner = [faces["boundary"], faces["inner"][a != b], faces["inner"][a != b][:, ::-1]]
    owner, corner = np.concatenate(owner), np.concatenate(corner)
    muscle = owner > 1
    return owner[muscle], corner[muscle]


def manifold(owner, corner, count):
    """Open edges, edges of more than two triangles, edges run twice the same way, vertices where fans only touch."""
    n = len(owner)
    start = np.concatenate([corner[:, k] for k in range(3)])
    end = np.concatenate([corner[:, (k + 1) % 3] for k in range(3)])
    face = np.tile(np.arange(n), 3)
    key = keys(np.stack([start, end], axis=1), count) * (owner.max() + 1) + np.tile(owner, 3)
    order = np.argsort(key, kind="stable")
    key, start, end, face = key[order], start[order], end[order], face[order]
    begin = np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]]))
    uses = np.diff(np.concatenate([begin, [len(key)]]))
    first = begin[uses == 2]
    second = first + 1

    # Corners of one vertex hang together across edges of two triangles
    flat = corner.ravel()
    names = np.arange(3 * n)

    def place(face, vertex):
        rows = corner[face]
        return 3 * face + np.argmax(rows == vertex[:, None], axis=1)

    links = [(place(face[first], v), place(face[second], v)) for v in (start[first], end[first])]
    fans = Components(3 * n, np.concatenate([l[0] for l in links]), np.concatenate([l[1] for l in links]))
    vertices = len(np.unique(flat * (owner.max() + 1) + np.repeat(owner, 3)))
    return {
        "open_edges": int((uses == 1).sum()),
        "crowded_edges": int((uses > 2).sum()),
        "misoriented_edges": int((start[first] == start[second]).sum()),
        "pinched_vertices": int(fans.count(names) - vertices),
    }


# --- surfaces, by vtk


def poly_data(points, triangles):
    used, local = np.unique(triangles, return_inverse=True)
    cells = np.empty((len(triangles), 4), np.int64)
    cells[:, 0] = 3
    cells[:, 1:] = local.reshape(-1, 3)
    array = vtk.vtkCellArray()
    array.SetCells(len(cells), numpy_to_vtkIdTypeArray(cells.ravel(), deep=True))
    vtk_points = vtk.vtkPoints()
    vtk_points.SetDataTypeToDouble()
    vtk_points.SetData(numpy_to_vtk(points[used], deep=True))
    out = vtk.vtkPolyData()
    out.SetPoints(vtk_points)
    out.SetPolys(array)
    return out


def read_obj(file):
    m = meshio.read(folder + "/" + file)
    return poly_data(m.points, m.cells_dict["triangle"])


def split_edges(surface):
    """How many edges vtk finds that do not lie between exactly two triangles."""
    edges = vtk.vtkFeatureEdges()
    edges.SetInputData(surface)
    edges.BoundaryEdgesOn()
    edges.NonManifoldEdgesOn()
    edges.FeatureEdgesOff()
    edges.ManifoldEdgesOff()
    edges.Update()
    return edges.GetOutput().GetNumberOfCells()


def distance(a, b):
    """Largest distance from corners, edges' middles and centres of a to b, and the other way round."""
    worst = []
    for surface, other in ((a, b), (b, a)):
        finer = vtk.vtkLinearSubdivisionFilter()
        finer.SetInputData(surface)
        finer.SetNumberOfSubdivisions(1)
        apart = vtk.vtkDistancePolyDataFilter()
        apart.SetInputConnection(0, finer.GetOutputPort())
        apart.SetInputData(1, other)
        apart.SignedDistanceOff()
        apart.ComputeSecondDistanceOff()
        apart.Update()
        out = apart.GetOutput()
        worst.append(max(float(vtk_to_numpy(data.GetArray("Distance")).max()) for data in (out.GetPointData(), out.GetCellData())))
    return max(worst)


def deviations(medit):
    out = {}
    for entry in model["mesh_references"]:
        if entry["kind"] not in ("skin", "bone"):
            continue
        original = next(s for s in model["surfaces"] if s["name"] == entry["name"] and s["kind"] == entry["kind"])
        mine = medit["triangles"][medit["reference"] == entry["reference"]]
        out[entry["name"]] = distance(poly_data(medit["points"], mine), read_obj(original["file"])) / model["skin_diagonal_m"]
    return out


def soundness():
    grid = with_vtk()
    points, tets, tissue, fiber = grid["points"], grid["tets"], grid["tissue"], grid["fiber"]
    det, bound = determinants(points, tets)
    faces = faces_of(points, tets, tissue)
    owner, corner = muscle_surfaces(faces, tissue)
    same = tissue[faces["inner_tets"][:, 0]] == tissue[faces["inner_tets"][:, 1]]
    pieces = Components(len(tets), faces["inner_tets"][same, 0], faces["inner_tets"][same, 1])
    centred = points - points.mean(axis=0)
    hull = centred[faces["boundary"]]
    norms = np.linalg.norm(fiber, axis=1)

    tissues = {}
    for entry in model["tissues"]:
        mine = tissue == entry["id"]
        tissues[entry["name"]] = {
            "kind": entry["kind"],
            "tets": int(mine.sum()),
            "volume": float(det[mine].sum() / 6),
            "pieces": pieces.count(np.flatnonzero(mine)),
            "longest_or_shortest_fiber": float(np.abs(norms[mine] - (1 if entry["kind"] == "muscle" else 0)).max(initial=0)),
    }
        if entry["kind"] == "muscle":
            surface = read_obj(entry["file"])
            tissues[entry["name"]]["triangles_missing"] = abs(int((owner == entry["id"]).sum()) - surface.GetNumberOfCells())
            tissues[entry["name"]]["split_edges"] = split_edges(surface)

    return {
        "only_tets": grid["kinds"] == {vtk.VTK_TETRA},
        "readers_differ": differ(grid, with_meshio_vtu()) + differ(grid, with_meshio_medit()),
        "tets": len(tets),
        "tets_not_positive": not_positive(points, tets, det, bound),
        "volume": float(det.sum() / 6),
        "volume_inside_boundary": float(np.einsum("ij,ij->", np.cross(hull[:, 0], hull[:, 1]), hull[:, 2]) / 6),
        "most_tets_on_a_face": faces["most"],
        "faces_with_tets_on_one_side": faces["same_side"],
        "muscle_surfaces": manifold(owner, corner, len(points)),
        "tissues": tissues,
    }


print(json.dumps(deviations(with_meshio_medit()) if sys.argv[2:] == ["deviations"] else soundness()))
