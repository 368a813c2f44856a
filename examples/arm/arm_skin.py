"""The skin of the arm, and of a trunk that two arms share, as implicit shapes (millimetres, see arm_bones.py)."""
import arm_bones as ab
import implicit as im


def hand():
    rays = ab.finger_joints()
    shapes = [
        im.ellipsoid(ab.HAND, (1, 3, 14), (31, 18, 32)),
        im.ellipsoid(ab.HAND, (1, 2, 55), (43, 15.5, 45)),
        im.ellipsoid(ab.HAND, (0, 3, 78), (41, 13.5, 27)),
        im.ellipsoid(ab.HAND, (24, 13, 34), (17, 17, 32)),  # ball of the thumb
        im.ellipsoid(ab.HAND, (-20, 9, 38), (15, 14, 34)),  # ball of the little finger
    ]
    palm = im.union(shapes, 18)
    thumb = im.tube(rays[0], [17, 13.5, 11.5, 9.5])
    fingers = []
    for k, ray in enumerate(rays[1:]):
        size = 0.87 if k == 3 else 1.0
        radii = [10, 11.5, 10, 9.3, 7.8]
        tip = ray[-1] + 0.002 * (ray[-1] - ray[-2])
        fingers.append(im.tube([*ray[:-1], tip], [size * r for r in radii]))
    # Fingers melt into the palm but not into one another
    together = fingers[0]
    for finger in fingers[1:]:
        together = im.union([together, finger], 2.0)
    return im.union([im.union([palm, thumb], 14), together], 9)


def arm():
    upper = im.limb(ab.UPPER, (4, 0), [
        # d, lateral, medial, anterior, posterior radius
        (-15, 50, 40, 44, 44),
        (40, 55, 46, 49, 50),
        (90, 49, 46, 49, 51),
        (140, 43, 45, 52, 51),
        (190, 42, 46, 53, 50),
        (235, 44, 46, 47, 45),
        (275, 46, 48, 39, 39),
        (305, 45, 49, 36, 37),
        (325, 43, 46, 36, 34),
    ])
    fore = im.limb(ab.FORE, (3, 0), [
        (-20, 43, 48, 36, 34),
        (10, 46, 49, 37, 37),
        (40, 51, 48, 40, 36),
        (75, 50, 46, 40, 34),
        (115, 44, 42, 36, 32),
        (160, 36, 37, 30, 28),
        (205, 32, 33, 24, 23),
        (235, 32, 31, 21, 20),
        (262, 31, 29, 19, 18),
    ])
    s = ab.SCAPULA.at
    shoulder = [
        im.ellipsoid(ab.UPPER, (7, 2, 6), (58, 56, 66)),  # deltoid
        im.plate(s(-98, -2, 40), s(-90, 0, -112), s(-4, -4, -4), 27),
        im.tube([s(-98, 8, 22), s(-45, 16, 24), s(10, 14, 24), s(30, 4, 22)], [26, 29, 30, 28]),
        im.tube([(34, 106, 22), (24, 142, 28), (12, 172, 26)], [25, 28, 32]),  # over the clavicle
        im.ellipsoid(ab.WORLD, (-4, 128, -18), (52, 62, 66)),  # where the chest was
        im.tube([(26, 112, -42), (20, 150, -34), (10, 180, -30)], [26, 32, 36]),  # fold of pectoralis
    ]
    bellies = [
        im.ellipsoid(ab.UPPER, (0, 30, 178), (27, 27, 72)),  # biceps
        im.ellipsoid(ab.UPPER, (22, -28, 125), (27, 28, 70)),  # lateral head of triceps
        im.ellipsoid(ab.UPPER, (-20, -27, 150), (25, 27, 75)),  # its long head
        im.ellipsoid(ab.FORE, (33, 10, 35), (23, 27, 72)),  # brachioradialis and the radial extensors
        im.ellipsoid(ab.FORE, (-27, 8, 60), (24, 30, 75)),  # flexors
    ]
    limb = im.union([im.union([upper, fore], 22), *bellies], 14)
    return im.union([limb, *shoulder[:1]], 24), im.union(shoulder[1:], 30)


def single():
    """Skin of the arm with its shoulder blade; the side towards the trunk is closed."""
    limb, girdle = arm()
    return im.union([im.union([limb, girdle], 34), hand()], 16)


def trunk():
    """Half of it counts: it is symmetric across Y = 0."""
    return im.union([
        im.ellipsoid(ab.WORLD, (2, 0, -85), (112, 172, 175)),
        im.ellipsoid(ab.WORLD, (-20, 0, 40), (88, 130, 48)),
        im.capsule([-30, 0, 40], [-18, 0, 100], 62, 54),  # neck
    ], 40)


def thorax():
    """Ribs and sternum as one solid egg: enough for muscles of the shoulder to lie on."""
    return im.union([
        im.ellipsoid(ab.WORLD, (14, 0, -105), (72, 118, 125)),
        im.capsule([70, 0, -55], [82, 0, -150], 9, 9),
    ], 14)


def whole():
    one = single()
    both = im.union([one, im.mirror(one)], 30)
    return im.union([trunk(), both], 40)
