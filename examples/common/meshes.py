"""Writing example meshes, and the checks that they pass before they are written."""
import numpy as np
import trimesh
from scipy.spatial import cKDTree

import curves as cv


def write_obj(path, parts, comment):
    """Several closed meshes in one file, one `o` each. `parts`: name -> mesh in metres, 10 µm kept."""
    lines, first = [f"# {comment}"], 1
    for name, mesh in parts.items():
        lines.append(f"o {name}")
        lines += ["v {:.5f} {:.5f} {:.5f}".format(*v) for v in mesh.vertices]
        lines += ["f {} {} {}".format(*(f + first)) for f in mesh.faces]
        first += len(mesh.vertices)
    path.write_text("\n".join(lines) + "\n")


def rounded(mesh):
    """As it will be read back."""
    return trimesh.Trimesh(np.round(np.asarray(mesh.vertices), 5), mesh.faces, process=False)


def crossings(mesh):
    """Pairs of triangles without a common vertex that cut one another."""
    triangles, faces = mesh.triangles, mesh.faces
    centre = triangles.mean(1)
    reach = np.linalg.norm(triangles - centre[:, None], axis=2).max(1)
    order = np.argsort(-reach)
    pairs = []
    tree = cKDTree(centre)
    for chunk in np.array_split(order, max(1, len(order) // 500)):
        for i, near in zip(chunk, tree.query_ball_point(centre[chunk], 2 * reach[chunk])):
            near = np.array([j for j in near if reach[j] < reach[i] or (reach[j] == reach[i] and j > i)], int)
            pairs.append(np.column_stack([np.full(len(near), i), near]))
    pairs = np.vstack(pairs)
    shared = (faces[pairs[:, 0]][:, :, None] == faces[pairs[:, 1]][:, None]).any((1, 2))
    pairs = pairs[~shared]
    low, high = triangles.min(1), triangles.max(1)
    touch = np.all((low[pairs[:, 0]] <= high[pairs[:, 1]]) & (low[pairs[:, 1]] <= high[pairs[:, 0]]), axis=1)
    pairs = pairs[touch]
    hit = np.zeros(len(pairs), bool)
    for first, second in ((0, 1), (1, 0)):
        edge_of, face_of = triangles[pairs[:, first]], triangles[pairs[:, second]]
        u, v = face_of[:, 1] - face_of[:, 0], face_of[:, 2] - face_of[:, 0]
        normal = np.cross(u, v)
        for k in range(3):
            a, d = edge_of[:, k], edge_of[:, (k + 1) % 3] - edge_of[:, k]
            slope = (d * normal).sum(1)
            with np.errstate(divide="ignore", invalid="ignore"):
                t = ((face_of[:, 0] - a) * normal).sum(1) / slope
                p = a + t[:, None] * d - face_of[:, 0]
                area = (normal * normal).sum(1)
                s1, s2 = (np.cross(p, v) * normal).sum(1) / area, (np.cross(u, p) * normal).sum(1) / area
            hit |= (t >= 0) & (t <= 1) & (s1 >= 0) & (s2 >= 0) & (s1 + s2 <= 1)
    return pairs[hit]


def gap(a, b):
    """Smallest distance between two meshes' vertices and the other's surface; negative where they intersect [m]."""
    first = cv.Surface(b.vertices, b.faces).distance(a.vertices)[0].min()
    return min(first, cv.Surface(a.vertices, a.faces).distance(b.vertices)[0].min())


def verify(parts, skin=None, joint_gap=0.001, cover=0.002):
    """Raises where a mesh is open, not manifold, inside out or cuts itself, or where meshes come too close."""
    everything = dict(parts, **({"skin": skin} if skin is not None else {}))
    for name, mesh in everything.items():
        if not (mesh.is_watertight and mesh.is_winding_consistent and mesh.volume > 0):
            raise SystemExit(f"{name} is not a closed surface that faces outward")
        if mesh.body_count != 1:
            raise SystemExit(f"{name} has {mesh.body_count} pieces")
        count = len(crossings(mesh))
        if count:
            raise SystemExit(f"{name} cuts itself in {count} pairs of triangles")
    names = list(parts)
    for i, name in enumerate(names):
        for other in names[i + 1 :]:
            if np.all(parts[name].bounds[0] < parts[other].bounds[1] + 0.01) and np.all(
                parts[other].bounds[0] < parts[name].bounds[1] + 0.01
            ):
                room = gap(parts[name], parts[other])
                print(f"  {name} to {other}: {1000 * room:.2f} mm")
                if room < joint_gap:
                    raise SystemExit(f"{name} and {other} are only {1000 * room:.2f} mm apart")
        if skin is not None:
            depth = -cv.Surface(skin.vertices, skin.faces).distance(parts[name].vertices)[0].max()
            print(f"  {name}: {len(parts[name].faces)} triangles, {1000 * depth:.1f} mm below the skin")
            if depth < cover:
                raise SystemExit(f"{name} comes to {1000 * depth:.1f} mm of the skin")
