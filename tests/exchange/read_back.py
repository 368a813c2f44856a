"""Reads an output folder with meshio and vtk, programs that we did not write, and prints what they saw as JSON."""

import json
import sys

import meshio
import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy


def volumes(points, tets, tissue):
    a, b, c, d = (points[tets[:, k]] for k in range(4))
    v = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6
    return {str(i): float(v[tissue == i].sum()) for i in np.unique(tissue)}, float(v.min())


def describe(points, tets, tissue, names, tet_fiber, vertex_fiber):
    by_tissue, smallest = volumes(points, tets, tissue)
    faces = np.sort(np.concatenate([tets[:, [1, 2, 3]], tets[:, [0, 2, 3]], tets[:, [0, 1, 3]], tets[:, [0, 1, 2]]]), axis=1)
    counts = np.unique(faces, axis=0, return_counts=True)[1]
    out = {
        "points": len(points),
        "tets": len(tets),
        "names": names,
        "volumes": by_tissue,
        "smallest": smallest,
        "most_tets_on_a_face": int(counts.max()),
        "boundary_faces": int((counts == 1).sum()),
    }
    if tet_fiber is not None:
        norms = np.linalg.norm(tet_fiber, axis=1)[tissue > 1]
        out["worst_fiber_norm"] = float(np.abs(norms - 1).max())
        out["fiber_sum"] = [float(x) for x in tet_fiber.sum(axis=0)]
        out["vertex_fiber_sum"] = [float(x) for x in vertex_fiber.sum(axis=0)]
    return out


def with_meshio_vtu(file):
    m = meshio.read(file)
    names = {k.removeprefix("tissue:"): int(np.ravel(v)[0]) for k, v in m.field_data.items()}
    return describe(m.points, m.cells_dict["tetra"], np.ravel(m.cell_data["tissue"][0]), names,
                    m.cell_data["fiber"][0], m.point_data["fiber"])


def with_vtk(file):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(file)
    reader.Update()
    grid = reader.GetOutput()
    tets = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4)
    field = grid.GetFieldData()
    names = {}
    for k in range(field.GetNumberOfArrays()):
        array = field.GetAbstractArray(k)
        if array.GetName().startswith("tissue:"):
            names[array.GetName().removeprefix("tissue:")] = int(array.GetTuple1(0))
    return describe(vtk_to_numpy(grid.GetPoints().GetData()), tets,
                    vtk_to_numpy(grid.GetCellData().GetArray("tissue")), names,
                    vtk_to_numpy(grid.GetCellData().GetArray("fiber")),
                    vtk_to_numpy(grid.GetPointData().GetArray("fiber")))


def with_meshio_medit(file):
    m = meshio.read(file)
    references = dict(zip([c.type for c in m.cells], m.cell_data["medit:ref"]))
    out = describe(m.points, m.cells_dict["tetra"], np.asarray(references["tetra"]), {}, None, None)
    values, counts = np.unique(references["triangle"], return_counts=True)
    out["triangles"] = {str(v): int(n) for v, n in zip(values, counts)}
    return out


folder = sys.argv[1]
print(json.dumps({
    "meshio_vtu": with_meshio_vtu(folder + "/anatomy.vtu"),
    "vtk": with_vtk(folder + "/anatomy.vtu"),
    "meshio_medit": with_meshio_medit(folder + "/anatomy.mesh"),
}))
