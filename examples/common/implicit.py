"""Smooth implicit modelling: shapes are functions from points #P×3 to distances #P (negative inside), in millimetres.

The functions bound the true distance from below near the surface, so carving with an offset leaves at least that gap.
"""
import numpy as np
import trimesh
from fast_simplification import simplify
from scipy.interpolate import PchipInterpolator
from skimage.measure import marching_cubes

import curves as cv


class Frame:
    """A place with three axes; `at` gives world points of local coordinates, `local` goes back."""

    def __init__(self, origin, axes):
        self.origin, self.axes = np.asarray(origin, float), np.asarray(axes, float)  # rows are the axes

    def at(self, *coordinates):
        return self.origin + np.asarray(coordinates, float) @ self.axes

    def local(self, points):
        return (points - self.origin) @ self.axes.T


def smooth_min(a, b, k):
    """Quadratic blend of width k: below min(a, b) by at most k/4."""
    h = np.maximum(k - np.abs(a - b), 0) / k
    return np.minimum(a, b) - h * h * k / 4


def union(shapes, k):
    def f(p):
        value = shapes[0](p)
        for shape in shapes[1:]:
            value = smooth_min(value, shape(p), k)
        return value
    return f


def carve(shape, other, gap, k=1.0):
    """`shape` without everything closer than `gap` to `other`."""
    return lambda p: -smooth_min(-shape(p), other(p) - gap, k)


def mirror(shape):
    """Across Y = 0."""
    return lambda p: shape(p * np.array([1.0, -1.0, 1.0]))


def ball(centre, radius):
    return lambda p: np.linalg.norm(p - centre, axis=1) - radius


def ellipsoid(frame, centre, radii):
    radii = np.asarray(radii, float)

    def f(p):
        q = frame.local(p) - centre
        k0, k1 = np.linalg.norm(q / radii, axis=1), np.linalg.norm(q / radii**2, axis=1)
        return k0 * (k0 - 1) / np.maximum(k1, 1e-9)
    return f


def capsule(a, b, ra, rb):
    a, b = np.asarray(a, float), np.asarray(b, float)

    def f(p):
        t = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        return np.linalg.norm(p - a - t[:, None] * (b - a), axis=1) - (ra + t * (rb - ra))
    return f


def near(shape, low, high, reach):
    """`shape` where it is closer than about `reach` to its box, else the distance to the box: nobody blends that far."""
    def f(p):
        away = np.linalg.norm(np.maximum(0, np.maximum(low - p, p - high)), axis=1)
        close = away < reach
        away[close] = shape(p[close])
        return away
    return f


def tube(points, radii, flat=None, reach=45.0):
    """A round rod along a spline. `flat` = (direction, factor) thins it along a direction."""
    points = np.asarray(points, float)
    samples, u = cv.spline(points, 5)
    radius = PchipInterpolator(np.arange(len(points)), radii)(u)

    def stretch(q):
        if flat is None:
            return q
        direction = np.asarray(flat[0]) / np.linalg.norm(flat[0])
        return q + (flat[1] - 1) * np.outer(q @ direction, direction)

    pieces = [
        capsule(stretch(samples[i : i + 1])[0], stretch(samples[i + 1 : i + 2])[0], radius[i], radius[i + 1])
        for i in range(len(samples) - 1)
    ]

    def f(p):
        q = stretch(p)
        value = pieces[0](q)
        for piece in pieces[1:]:
            value = np.minimum(value, piece(q))
        return value if flat is None else value / flat[1]

    room = np.max(radii)
    return near(f, samples.min(0) - room, samples.max(0) + room, reach)


def plate(a, b, c, thickness):
    """A triangle with rounded rim, `thickness` to either side."""
    a, b, c = (np.asarray(v, float) for v in (a, b, c))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal)

    def f(p):
        inside = np.ones(len(p), bool)
        rim = np.full(len(p), np.inf)
        for v, w in ((a, b), (b, c), (c, a)):
            edge = w - v
            t = np.clip((p - v) @ edge / (edge @ edge), 0, 1)
            rim = np.minimum(rim, np.linalg.norm(p - v - t[:, None] * edge, axis=1))
            inside &= np.cross(edge, p - v) @ normal >= 0
        return np.where(inside, np.abs((p - a) @ normal), rim) - thickness
    return f


def limb(frame, centre, stations):
    """A sweep along the frame's third axis with four radii (lateral, medial, anterior, posterior) per station."""
    stations = np.asarray(stations, float)
    s = stations[:, 0]
    radius = [PchipInterpolator(s, stations[:, 1 + i]) for i in range(4)]

    def f(p):
        q = frame.local(p)
        t = np.clip(q[:, 2], s[0], s[-1])
        l, a, over = q[:, 0] - centre[0], q[:, 1] - centre[1], q[:, 2] - t
        rl = np.where(l > 0, radius[0](t), radius[1](t))
        ra = np.where(a > 0, radius[2](t), radius[3](t))
        small = np.minimum(rl, ra)
        return (np.sqrt((l / rl) ** 2 + (a / ra) ** 2 + (over / small) ** 2) - 1) * small
    return f


def _grid(low, high, step):
    counts = np.ceil((high - low) / step).astype(int) + 1
    axes = [low[i] + step * np.arange(counts[i]) for i in range(3)]
    return counts, np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def sample(shape, low, high, step, coarse=4, border=True):
    """The shape's values on a grid, true to the shape near its surface and only right in sign elsewhere.

    Returns the field and its lowest corner; the box shrinks to what the shape fills. `border`: an error if the shape
    reaches the border of the box; otherwise the box's low Y stays.
    """
    low, high = np.asarray(low, float), np.asarray(high, float)
    _, points = _grid(low, high, 8.0)
    filled = points[shape(points) < 12.0]
    if len(filled) == 0 or border and (np.any(filled.min(0) <= low) or np.any(filled.max(0) >= high)):
        raise SystemExit("the shape is empty or reaches the border of its box")
    low = filled.min(0) - 4 if border else np.array([filled[:, 0].min() - 4, low[1], filled[:, 2].min() - 4])
    block = coarse * step
    counts, points = _grid(low, filled.max(0) + 4 + block, block)
    rough = shape(points).reshape(counts)
    field = np.repeat(np.repeat(np.repeat(rough, coarse, 0), coarse, 1), coarse, 2).astype(np.float32)
    # A block is looked at closely where the surface may pass within its diagonal of the corner it was judged by
    near = np.argwhere(np.abs(rough) < 2.2 * block)
    offsets = np.stack(np.meshgrid(*[np.arange(coarse)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    for some in np.array_split(near, max(1, len(near) // 4000)):
        index = (some[:, None] * coarse + offsets[None]).reshape(-1, 3)
        field[tuple(index.T)] = shape(low + step * index)
    return field, low


def mesh_of(shape, low, high, step, triangles, smoothing=6):
    """Closed triangle mesh of {shape < 0} in the box, thinned to about `triangles`. Millimetres."""
    field, low = sample(shape, low, high, step)
    vertices, faces, _, _ = marching_cubes(field, 0.0, spacing=(step,) * 3)
    mesh = trimesh.Trimesh(vertices + low, faces[:, ::-1])
    mesh = max(mesh.split(only_watertight=False), key=lambda part: len(part.faces))
    trimesh.smoothing.filter_taubin(mesh, lamb=0.5, nu=0.52, iterations=smoothing)
    vertices, faces = simplify(np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces), target_count=triangles)
    mesh = trimesh.Trimesh(vertices, faces, process=True)
    if mesh.volume < 0:
        mesh.invert()
    return mesh
