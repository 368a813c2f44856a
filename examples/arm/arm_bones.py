"""The bones of a left arm as implicit shapes. Millimetres; X is anterior, Y left (lateral), Z up.

Sizes follow an adult: humerus 31 cm, radius 24 cm. The arm hangs 12° abducted, the elbow is flexed by 20° and
carries 7°, the forearm is supinated (palm forward).
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "common"))
import implicit as im  # noqa: E402

HEAD = np.array([0.0, 185.0, 0.0])  # centre of the humeral head
WORLD = im.Frame([0, 0, 0], np.eye(3))


def turn(v, axis, degrees):
    axis, angle = np.asarray(axis) / np.linalg.norm(axis), np.radians(degrees)
    return v * np.cos(angle) + np.cross(axis, v) * np.sin(angle) + axis * (axis @ v) * (1 - np.cos(angle))


def unit(v):
    return v / np.linalg.norm(v)


def segment(origin, distal, lateral):
    """A frame with the axes (lateral, anterior, distal)."""
    distal = unit(distal)
    lateral = unit(lateral - distal * (lateral @ distal))
    anterior = np.cross(distal, lateral)
    return im.Frame(origin, [lateral, anterior * np.sign(anterior[0]), distal])


_down = np.array([0, np.sin(np.radians(12)), -np.cos(np.radians(12))])
UPPER = segment(HEAD, _down, np.array([0.0, 1.0, 0.2]))
_fore = np.cos(np.radians(20)) * UPPER.axes[2] + np.sin(np.radians(20)) * UPPER.axes[1]
FORE = segment(UPPER.at(0, 0, 300), _fore + np.tan(np.radians(7)) * UPPER.axes[0], UPPER.axes[0])
HAND = segment(FORE.at(2, 1, 242), FORE.axes[2] - 0.10 * FORE.axes[0] + 0.04 * FORE.axes[1], FORE.axes[0])
# Scapula: axes lateral in its plane (30° in front of the frontal plane), dorsal, up; origin in the glenoid
_s1 = np.array([np.sin(np.radians(30)), np.cos(np.radians(30)), 0.0])
_s2 = np.array([-np.cos(np.radians(30)), np.sin(np.radians(30)), 0.0])
SCAPULA = im.Frame(HEAD - 28 * _s1, [_s1, _s2, [0, 0, 1]])


def humerus():
    u, ball = UPPER.at, im.ball
    shaft = im.tube([u(7, 1, 10), u(9, 2, 40), u(10, 2, 90), u(9, 2, 150), u(6, 0, 215), u(2, 0, 262)],
                    [20, 15.5, 12, 10.5, 10, 11])
    flare = im.tube([u(4, 0, 225), u(-22, -2, 279)], [8, 7.5]), im.tube([u(6, 0, 225), u(22, 0, 281)], [8, 7])
    web = im.plate(u(3, -1, 235), u(-22, -1, 284), u(20, -1, 284), 5.5)
    blade = im.union([shaft, *flare, web], 10)
    joint = im.union([
        im.tube([u(-19, 3, 298), u(-8, 3, 298), u(4, 3, 298)], [13, 9.5, 11]),  # trochlea, a spool
        ball(u(14, 5, 296), 10.5),  # capitulum
    ], 3)
    epicondyles = [im.ellipsoid(UPPER, (-29, -3, 284), (9, 7, 11)), im.ellipsoid(UPPER, (25, -1, 285), (7, 7, 11))]
    body = im.union([blade, joint, *epicondyles], 6)
    body = im.union([body, ball(HEAD, 23)], 5)
    tubercles = [im.ellipsoid(UPPER, (20, -3, 6), (13, 15, 19)), im.ellipsoid(UPPER, (8, 17, 11), (8, 8, 12))]
    body = im.union([body, *tubercles], 7)
    body = im.union([body, im.ellipsoid(UPPER, (17, 5, 128), (7, 6, 26))], 8)  # deltoid tuberosity
    groove = im.tube([u(15, 21, -8), u(15, 20, 14), u(14, 17, 45)], [3.0, 3.5, 2.0])
    body = im.carve(body, groove, 0.5, 4)
    body = im.carve(body, ball(u(-7, -15, 283), 9.5), 0, 4)  # olecranon fossa
    body = im.carve(body, ball(u(-7, 15, 283), 7), 0, 4)  # coronoid fossa
    return body


def scapula():
    s = SCAPULA.at
    superior, inferior, neck = s(-100, 3, 44), s(-92, 6, -118), s(-14, 0, -4)
    blade = im.plate(superior, inferior, neck, 2.6)
    borders = [
        im.tube([s(-12, -1, -14), s(-42, 1, -55), inferior], [7, 6, 5.5]),
        im.tube([superior, s(-103, 5, -10), s(-101, 6, -70), inferior], [4, 4, 4, 5.5]),
        im.tube([superior, s(-56, 1, 22), s(-16, 0, 12)], [4, 3.5, 6]),
    ]
    glenoid = [im.ellipsoid(SCAPULA, (-4, 0, -1), (9, 13, 19)), im.capsule(s(-26, 0, -2), s(-6, 0, 0), 8, 11)]
    ridge = im.tube([s(-101, 5, 15), s(-60, 17, 18), s(-20, 30, 23), s(8, 34, 30)], [4, 4, 5, 6.5])
    wall = im.plate(s(-98, 3, 14), s(-22, 1, 14), s(-8, 31, 25), 2.6)
    acromion = im.tube([s(4, 34, 30), s(24, 28, 38), s(38, 10, 40), s(36, -4, 39)], [10, 13, 14, 10],
                       flat=((0, 0, 1), 2.2))
    coracoid = im.tube([s(-9, -3, 14), s(-6, -16, 29), s(3, -30, 30), s(13, -38, 22)], [9, 8, 6.5, 5.5])
    body = im.union([blade, *borders, *glenoid], 7)
    return im.union([body, wall, ridge, acromion, coracoid], 6)


def clavicle():
    """Its lateral two thirds."""
    return im.tube([(36, 98, 33), (36, 118, 37), (24, 142, 42), (13, 160, 43), (10, 176, 42)],
                   [6.5, 6.0, 6.0, 6.5, 7.0], flat=((0, 0, 1), 1.15))


def radius():
    f = FORE.at
    head = im.ellipsoid(FORE, (15, 5, 17), (10.5, 10.5, 8))
    shaft = im.tube([f(15, 5, 18), f(14, 4, 32), f(17, 3, 75), f(20, 2, 125), f(18, 2, 185), f(13, 2, 226)],
                    [8, 6.5, 7, 7.5, 8, 11])
    flare = im.ellipsoid(FORE, (11, 2, 229), (16, 10, 11))
    styloid = im.capsule(f(22, 2, 226), f(25, 2, 243), 6, 4)
    body = im.union([shaft, head, flare, styloid], 6)
    return im.union([body, im.ellipsoid(FORE, (8, 7, 42), (6, 6, 10))], 5)  # radial tuberosity


def ulna():
    f = FORE.at
    olecranon = im.ellipsoid(FORE, (-8, -17, -6), (11, 9.5, 19))
    coronoid = im.ellipsoid(FORE, (-8, 11, 17), (10.5, 9, 8))
    shaft = im.tube([f(-8, -11, 6), f(-8, -4, 24), f(-10, -7, 70), f(-13, -7, 125), f(-15, -4, 190), f(-14, -3, 232)],
                    [11, 12.5, 8.5, 7.5, 6, 8])
    styloid = im.capsule(f(-17, -6, 232), f(-19, -8, 243), 4, 3)
    return im.union([shaft, olecranon, coronoid, styloid], 7)


def finger_joints():
    """Points of thumb and fingers from the carpus to the tips, little finger last."""
    h = HAND.at
    thumb = [h(19, 6, 12), h(43, 14, 46), h(57, 17, 76), h(66, 15, 101)]
    rays = [thumb]
    for base, knuckle, lengths, bend in (
        ((16, 1, 30), (23, 1, 93), (40, 24, 17), (6, 14, 10)),
        ((5, 2, 32), (6, 2, 96), (44, 28, 18), (8, 16, 10)),
        ((-7, 1, 31), (-10, 2, 91), (41, 26, 18), (11, 18, 11)),
        ((-17, 0, 29), (-25, 3, 84), (33, 19, 16), (14, 19, 11)),
    ):
        points = [h(*base), h(*knuckle)]
        outward = (knuckle[0] - base[0]) / 63.0
        direction = unit(HAND.axes[2] + outward * HAND.axes[0])
        for length, degrees in zip(lengths, bend):
            direction = turn(direction, np.cross(HAND.axes[2], HAND.axes[1]), degrees)
            points.append(points[-1] + length * direction)
        rays.append(points)
    return rays


def hand():
    carpus = [
        im.ellipsoid(HAND, (0, 1, 14), (22, 9.5, 12)),
        im.ellipsoid(HAND, (0, 1, 28), (23, 8.5, 9)),
    ]
    bones = []
    for k, ray in enumerate(finger_joints()):
        size = 0.86 if k == 4 else 1.0
        for i in range(len(ray) - 1):
            a, b = ray[i], ray[i + 1]
            last = i == len(ray) - 2
            thick = size * (6.0, 5.2, 4.4, 4.0)[min(i, 3)]
            bones.append(im.tube([a, a + 0.5 * (b - a), b], [thick * 1.1, thick * 0.82, thick * (0.85 if last else 1.1)],
                                 reach=10.0))
    return im.union([im.union(carpus, 8), *bones], 3.5)


def shapes():
    """Every bone; where two meet, the later one makes room for the earlier one."""
    room = 1.9
    result = {"scapula": None, "clavicle": None, "humerus": humerus()}
    result["scapula"] = im.carve(scapula(), result["humerus"], room)
    result["clavicle"] = im.carve(clavicle(), result["scapula"], room)
    result["radius"] = im.carve(radius(), result["humerus"], room)
    result["ulna"] = im.carve(im.carve(ulna(), result["humerus"], room), result["radius"], room)
    result["hand"] = im.carve(im.carve(hand(), result["radius"], room), result["ulna"], room)
    return result


BOX = (-140, 20, -800), (280, 440, 100)  # holds everything [mm]
TRIANGLES = {"scapula": 5200, "clavicle": 1200, "humerus": 4200, "radius": 2600, "ulna": 3000, "hand": 6000}
