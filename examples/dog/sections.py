"""Reads curves out of an artist's muscle: section centroids between two ends, strips of a sheet, local radius."""
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree


class Sections:
    """Sections of a muscle's surface at equal flow t between its origins (0) and insertions (1).

    t = d0 / (d0 + d1) with the distances along the surface's edges to the two ends, so bent muscles unroll.
    """

    def __init__(self, mesh, starts, ends):
        self.vertices = np.asarray(mesh.vertices)
        edges = mesh.edges_unique
        length = mesh.edges_unique_length
        count = len(self.vertices)
        graph = coo_matrix((length, edges.T), shape=(count, count))
        tree = cKDTree(self.vertices)
        d0, d1 = (
            dijkstra(graph, directed=False, indices=tree.query(np.atleast_2d(p))[1], min_only=True)
            for p in (starts, ends)
        )
        self.t = d0 / np.maximum(d0 + d1, 1e-9)
        self.area = np.zeros(count)
        np.add.at(self.area, mesh.faces, mesh.area_faces[:, None] / 3)

    def at(self, t, strip=0, strips=1, flow=None):
        """Centroid of the section at t (of strip `strip` of `strips`), and the section's mean radius [m]."""
        width = 0.03
        while True:
            weight = self.area * np.exp(-0.5 * ((self.t - t) / width) ** 2)
            weight[np.abs(self.t - t) > 3 * width] = 0
            if (weight > 0).sum() >= 12:
                break
            width *= 1.4
        used = weight > 0
        points, weight = self.vertices[used], weight[used] / weight[used].sum()
        centre = weight @ points
        spread = points - centre
        if flow is not None:
            spread = spread - np.outer(spread @ flow, flow)
        radius = weight @ np.linalg.norm(spread, axis=1)
        if strips == 1:
            return centre, radius, None
        _, _, axes = np.linalg.svd(spread * np.sqrt(weight)[:, None], full_matrices=False)
        return centre, radius, (points, weight, spread, axes[0], strip, strips)

    def path(self, strip=0, strips=1, count=15):
        """Points along the muscle (without its ends) and radii there. Strips are counted along the widest direction,
        turned so that it points to +X, then +Z, where it does not follow from its neighbour."""
        ts = np.linspace(0.06, 0.94, count)
        centres = np.array([self.at(t)[0] for t in ts])
        flows = np.gradient(centres, axis=0)
        flows /= np.linalg.norm(flows, axis=1, keepdims=True)
        sections = [self.at(t, strip, strips, flow) for t, flow in zip(ts, flows)]
        radii = np.array([s[1] for s in sections])
        if strips == 1:
            return centres, radii
        points, previous = [], None
        order = np.argsort(np.abs(ts - 0.5))  # orient from the belly outward
        axes = {}
        for k in order:
            axis = sections[k][2][3]
            reference = np.array([1.0, 0.0, 0.3]) if not axes else axes[min(axes, key=lambda j: abs(j - k))]
            axes[k] = axis if axis @ reference >= 0 else -axis
        for k in range(count):
            rim, weight, spread, _, _, _ = sections[k][2]
            q = spread @ axes[k]
            low, high = np.quantile(q, [0.04, 0.96])
            # Strips do not reach the rim: a curve there would push its muscle over the edge
            aim = low + (high - low) * (0.5 + 0.72 * ((strip + 0.5) / strips - 0.5))
            kernel = weight * np.exp(-0.5 * ((q - aim) / (0.22 * (high - low) / strips + 1e-4)) ** 2)
            points.append(kernel @ rim / kernel.sum())
        return np.array(points), radii
