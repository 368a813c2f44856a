"""Curves of muscles: the program's own spline, distances to meshes, and relaxing a set of curves into free space.

Lengths in metres. A curve is an array #P×3 of control points; the first and the last one are its ends.
"""
import igl
import numpy as np
from scipy.spatial import cKDTree


def spline(points, per_segment=24):
    """Centripetal Catmull-Rom through `points`, control points mirrored across the ends, as ecorche/mesh/spline.h.

    Returns samples #S×3 and their parameters u (control point p sits at u = p).
    """
    points = np.asarray(points, float)
    if len(points) == 2:
        u = np.linspace(0, 1, 3 * per_segment)
        return points[0] + u[:, None] * (points[1] - points[0]), u
    extended = np.vstack([2 * points[0] - points[1], points, 2 * points[-1] - points[-2]])
    knots = np.concatenate([[0], np.cumsum(np.sqrt(np.linalg.norm(np.diff(extended, axis=0), axis=1)))])
    samples, parameters = [], []
    for k in range(1, len(extended) - 2):
        last = k == len(extended) - 3
        s = np.linspace(0, 1, per_segment + 1)[: None if last else -1]
        t = (knots[k] + s * (knots[k + 1] - knots[k]))[:, None]

        def blend(a, b, i, j):
            return ((knots[j] - t) * a + (t - knots[i]) * b) / (knots[j] - knots[i])

        a1 = blend(extended[k - 1], extended[k], k - 1, k)
        a2 = blend(extended[k], extended[k + 1], k, k + 1)
        a3 = blend(extended[k + 1], extended[k + 2], k + 1, k + 2)
        samples.append(blend(blend(a1, a2, k - 1, k + 1), blend(a2, a3, k, k + 2), k, k + 1))
        parameters.append(k - 1 + s)
    return np.vstack(samples), np.concatenate(parameters)


def arc_length(samples):
    """Length from the first sample to each one."""
    return np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(samples, axis=0), axis=1))])


def resample(polyline, count):
    """`count` points at equal arc length along a polyline."""
    s = arc_length(polyline)
    return np.stack([np.interp(np.linspace(0, s[-1], count), s, polyline[:, c]) for c in range(3)], axis=1)


class Surface:
    """A closed triangle mesh that answers signed distances: positive outside."""

    def __init__(self, vertices, faces):
        self.vertices = np.ascontiguousarray(vertices, float)
        self.faces = np.ascontiguousarray(faces, np.int64)
        self.low, self.high = self.vertices.min(0), self.vertices.max(0)

    def distance(self, points):
        """Signed distance #Q, closest point #Q×3 and the direction #Q×3 in which the distance grows."""
        points = np.ascontiguousarray(np.atleast_2d(points), float)
        kind = igl.SIGNED_DISTANCE_TYPE_FAST_WINDING_NUMBER
        signed, _, closest, _ = igl.signed_distance(points, self.vertices, self.faces, kind)
        signed = np.asarray(signed).ravel()
        away = (points - closest) * np.sign(signed)[:, None]
        return signed, closest, away / np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-12)

    def project(self, point):
        """The surface's point that is closest to `point`."""
        return self.distance(point)[1][0]


class Bones:
    """Many surfaces at once; asks only those whose box is near."""

    def __init__(self, surfaces):
        self.surfaces = surfaces  # name -> Surface

    def distance(self, points, reach=0.02):
        """Smallest signed distance over the bones (at most `reach`), with the direction away and the bone's name."""
        points = np.atleast_2d(points)
        best = np.full(len(points), reach)
        away = np.zeros_like(points)
        name = np.full(len(points), "", object)
        for bone, surface in self.surfaces.items():
            near = np.all((points > surface.low - reach) & (points < surface.high + reach), axis=1).nonzero()[0]
            if len(near) == 0:
                continue
            signed, _, direction = surface.distance(points[near])
            closer = near[signed < best[near]]
            mask = signed < best[near]
            best[closer], away[closer], name[closer] = signed[mask], direction[mask], bone
        return best, away, name


def spread_ends(points, anchors, bones, apart=0.005, rounds=80):
    """Slides ends that crowd on one bone apart along its surface, in place.

    @param anchors  for every curve the surfaces its start and its end lie on, keys of `bones`
    """
    where = [(i, k) for i in range(len(points)) for k in (0, -1) if anchors[i][k] in bones]
    for _ in range(rounds):
        at = np.array([points[i][k] for i, k in where])
        gap = at[:, None] - at[None]
        length = np.linalg.norm(gap, axis=2) + np.eye(len(at))
        push = (gap / np.maximum(length, 1e-6)[..., None] * np.maximum(0, apart - length)[..., None]).sum(1)
        for (i, k), step in zip(where, push):
            if np.linalg.norm(step) > 1e-5:
                points[i][k] = bones[anchors[i][k]].project(points[i][k] + 0.3 * step)


def basis(points, per_segment=24):
    """How much each sample of the spline moves with each control point: hat functions in u, enough for pushing."""
    _, u = spline(points, per_segment)
    return np.maximum(0, 1 - np.abs(u[:, None] - np.arange(len(points))[None, :]))


def relax(curves, bones, skin, *, bone_margin=0.0035, skin_margin=0.004, apart=0.005, rounds=60, stiffness=0.15,
          same=None, limits=()):
    """Move inner control points until curves keep clear of bones, skin and one another.

    @param curves  list of #P×3; ends stay. Changed copies are returned.
    @param same    same[i]: curves with equal entries belong together and do not repel one another
    @param limits  half spaces (point, normal) to stay in
    Margins shrink linearly over the first and last centimetre, where a curve has to reach its bone.
    """
    curves = [np.array(c, float) for c in curves]
    wanted = [c.copy() for c in curves]
    same = list(range(len(curves))) if same is None else same
    for _ in range(rounds):
        sampled = [spline(c, 12)[0] for c in curves]
        weights = [basis(c, 12) for c in curves]
        owner = np.concatenate([np.full(len(s), i) for i, s in enumerate(sampled)])
        group = np.array([same[i] for i in owner], dtype=object)
        everything = np.vstack(sampled)
        ease = np.concatenate([np.clip(np.minimum(a, a[-1] - a) / 0.010, 0.05, 1) for a in map(arc_length, sampled)])

        push = np.zeros_like(everything)
        signed, away, _ = bones.distance(everything, reach=bone_margin + 0.002)
        push += np.maximum(0, bone_margin * ease - signed)[:, None] * away
        depth, _, out = skin.distance(everything)
        push -= np.maximum(0, depth + skin_margin * ease)[:, None] * out
        for point, normal in limits:
            push += np.maximum(0, 0.003 - (everything - point) @ normal)[:, None] * np.asarray(normal) * ease[:, None]
        pairs = cKDTree(everything).query_pairs(apart, output_type="ndarray")
        pairs = pairs[group[pairs[:, 0]] != group[pairs[:, 1]]]
        if len(pairs):
            gap = everything[pairs[:, 0]] - everything[pairs[:, 1]]
            length = np.maximum(np.linalg.norm(gap, axis=1, keepdims=True), 1e-9)
            shove = 0.25 * gap / length * np.maximum(0, apart - length)
            for side, sign in ((0, 1), (1, -1)):
                strongest = np.zeros_like(push)
                np.add.at(strongest, pairs[:, side], sign * shove)
                size = np.linalg.norm(strongest, axis=1, keepdims=True)
                push += strongest * np.minimum(1, apart / np.maximum(size, 1e-12) / 4) * ease[:, None]

        for i, curve in enumerate(curves):
            mine = owner == i
            w, p = weights[i], push[mine]
            strength = np.linalg.norm(p, axis=1, keepdims=True)
            # The largest push in reach of a control point decides, not the mean: a short thin bone must not be missed
            for k in range(1, len(curve) - 1):
                weighted = w[:, k : k + 1] * strength
                if weighted.max() < 1e-6:
                    curve[k] += stiffness * 0.2 * (wanted[i][k] - curve[k])
                    continue
                share = (weighted / weighted.max()) ** 4 * w[:, k : k + 1]
                curve[k] += 0.6 * (share * p).sum(0) / share.sum()
    return curves


def unfold(curve, values, most=110.0):
    """Without the inner control points at which a curve doubles back by more than `most` degrees, sharpest first.

    Sections of a short thick muscle need not follow one another along it, and no fibre can follow such a hairpin.
    """
    curve, values = np.array(curve, float), np.array(values, float)
    while len(curve) > 2:
        step = np.diff(curve, axis=0)
        step /= np.linalg.norm(step, axis=1, keepdims=True)
        turn = np.degrees(np.arccos(np.clip((step[1:] * step[:-1]).sum(1), -1, 1)))
        if turn.max() <= most:
            break
        sharpest = 1 + int(np.argmax(turn))
        curve, values = np.delete(curve, sharpest, axis=0), np.delete(values, sharpest)
    return curve, values


def refine(curves, values, bones, skin, *, bone_margin=0.0025, skin_margin=0.003, limit=8):
    """Gives a curve one more control point where it still comes too close, pushed clear. True where it did."""
    grown = []
    for i, curve in enumerate(curves):
        samples, u = spline(curve, 24)
        s = arc_length(samples)
        ease = np.clip(np.minimum(s, s[-1] - s) / 0.010, 0.0, 1)
        signed, away, _ = bones.distance(samples)
        depth, _, out = skin.distance(samples)
        lacks_bone, lacks_skin = bone_margin * ease - signed, depth + skin_margin * ease
        # Not beside a point that is there already, and not so near an end that the bone below is the curve's own
        free = (s > 0.003) & (s < s[-1] - 0.003) & (np.abs(u - np.round(u)) > 0.15)
        lack = np.where(free, np.maximum(lacks_bone, lacks_skin), -1)
        worst = int(np.argmax(lack))
        grown.append(bool(lack[worst] > 0.0005 and len(curve) < limit))
        if not grown[-1]:
            continue
        step = (lacks_bone[worst] + 0.001) * away[worst] if lacks_bone[worst] > lacks_skin[worst] else (
            -(lacks_skin[worst] + 0.001) * out[worst])
        at = int(np.floor(u[worst])) + 1
        share = u[worst] - np.floor(u[worst])
        curves[i] = np.insert(curve, at, samples[worst] + step, axis=0)
        values[i] = np.insert(values[i], at, (1 - share) * values[i][at - 1] + share * values[i][at])
    return grown


def check(curves, names, bones, skin, *, limits=()):
    """Complaints about curves that leave skin, enter bone, are too short or meet another; empty when all is well."""
    complaints, sampled = [], [spline(c, 24)[0] for c in curves]
    for name, samples in zip(names, sampled):
        s = arc_length(samples)
        inner = (s > 0.010) & (s < s[-1] - 0.010)
        if s[-1] < 0.005:
            complaints.append(f"{name}: only {1000 * s[-1]:.1f} mm long")
        signed, _, bone = bones.distance(samples)
        worst = np.argmin(np.where(inner, signed, 1))
        if inner.any() and signed[worst] < 0.0015:
            complaints.append(f"{name}: {1000 * signed[worst]:.1f} mm from {bone[worst]}")
        free = (s > 0.002) & (s < s[-1] - 0.002)
        worst = np.argmin(np.where(free, signed, 1))
        if signed[worst] < -0.0003:
            complaints.append(f"{name}: {-1000 * signed[worst]:.1f} mm inside {bone[worst]} at {s[worst] / s[-1]:.2f}")
        depth = skin.distance(samples)[0]
        if inner.any() and depth[inner].max() > -0.002:
            complaints.append(f"{name}: skin {-1000 * depth[inner].max():.1f} mm away")
        if depth.max() > -0.0005:
            complaints.append(f"{name}: skin {-1000 * depth.max():.1f} mm away near an end")
        for point, normal in limits:
            if ((samples - point) @ normal)[inner].min(initial=1) < 0.001:
                complaints.append(f"{name}: crosses the plane {normal}")
    for i in range(len(curves)):
        for j in range(i + 1, len(curves)):
            gap = cKDTree(sampled[i]).query(sampled[j])[0].min()
            if gap < 0.002 and names[i].split("/")[0] != names[j].split("/")[0]:
                complaints.append(f"{names[i]} and {names[j]}: {1000 * gap:.1f} mm apart")
    return complaints
