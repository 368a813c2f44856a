"""The muscles of the arm: origin, course and insertion in the frames of arm_bones.py (millimetres).

u: upper arm (lateral, anterior, distal from the humeral head); f: forearm (the same from the elbow); s: scapula
(lateral, dorsal, up from the glenoid); h: hand (lateral, palmar, distal from the wrist); w: world.
Volumes to fit tissue values to are in reference_volumes.csv: means of ten adults [Holzbaur, Murray, Gold and Delp 2007,
J. Biomech. 40], and what is aimed at: half as much again, because the skin is an athlete's.
"""
import dataclasses
from typing import Optional

import arm_bones as ab

u, f, s, h = ab.UPPER.at, ab.FORE.at, ab.SCAPULA.at, ab.HAND.at


def w(*at):
    return at


@dataclasses.dataclass
class Head:
    name: str
    start: tuple  # bone, point
    course: list
    end: tuple
    values: Optional[list] = None  # at every point; else a belly between two tendons


@dataclasses.dataclass
class Muscle:
    name: str
    group: str
    layer: int
    heads: list
    anisotropy: Optional[tuple] = None  # λ₂, λ₃, rotation [°]
    value: float = 1.0


MUSCLES = [
    Muscle("deltoid", "shoulder", 2, [
        Head("clavicular part", ("clavicle", w(17, 158, 44)), [u(20, 37, 5), u(34, 31, 45), u(32, 18, 92)],
             ("humerus", u(20, 10, 122))),
        Head("acromial part", ("scapula", s(54, 4, 39)), [u(48, -2, 8), u(50, 0, 52), u(38, 3, 100)],
             ("humerus", u(22, 4, 138))),
        Head("spinal part", ("scapula", s(-14, 34, 25)), [s(22, 42, -4), u(38, -30, 52), u(34, -13, 98)],
             ("humerus", u(20, -2, 124))),
    ]),
    Muscle("supraspinatus", "rotator cuff", 0, [
        Head("", ("scapula", s(-86, 6, 28)), [s(-58, 12, 33), s(-18, 9, 31), s(14, 3, 28)], ("humerus", u(22, -2, -13))),
    ]),
    Muscle("infraspinatus", "rotator cuff", 1, [
        Head("upper part", ("scapula", s(-84, 6, -8)), [s(-55, 15, -8), s(-14, 25, 0), s(14, 28, 4)],
             ("humerus", u(27, -12, -4)), [0.9, 1.0, 1.0, 0.8, 0.6]),
        Head("middle part", ("scapula", s(-88, 7, -32)), [s(-58, 17, -26), s(-14, 26, -9), s(14, 29, -1)],
             ("humerus", u(27, -14, 0)), [0.9, 1.0, 1.0, 0.8, 0.6]),
        Head("lower part", ("scapula", s(-84, 7, -58)), [s(-56, 16, -45), s(-14, 25, -18), s(14, 28, -6)],
             ("humerus", u(26, -15, 4)), [0.9, 1.0, 1.0, 0.8, 0.6]),
    ]),
    Muscle("teres_minor", "rotator cuff", 1, [
        Head("", ("scapula", s(-48, 8, -68)), [s(-24, 17, -48), s(8, 24, -24)], ("humerus", u(21, -17, 16))),
    ]),
    Muscle("subscapularis", "rotator cuff", 0, [
        Head("upper part", ("scapula", s(-78, -3, 8)), [s(-48, -13, 2), s(-14, -20, 2), s(12, -26, 0)],
             ("humerus", u(7, 23, 6)), [0.9, 1.0, 1.0, 0.8, 0.6]),
        Head("middle part", ("scapula", s(-80, -3, -26)), [s(-52, -15, -21), s(-16, -22, -9), s(10, -27, -5)],
             ("humerus", u(7, 24, 10)), [0.9, 1.0, 1.0, 0.8, 0.6]),
        Head("lower part", ("scapula", s(-76, -3, -62)), [s(-50, -14, -46), s(-16, -20, -20), s(10, -25, -10)],
             ("humerus", u(7, 23, 14)), [0.9, 1.0, 1.0, 0.8, 0.6]),
    ]),
    Muscle("teres_major", "shoulder", 1, [
        Head("", ("scapula", s(-86, 12, -108)), [s(-58, 12, -92), s(-18, -2, -66), u(-14, 10, 50)],
             ("humerus", u(0, 13, 58))),
    ]),
    Muscle("coracobrachialis", "upper arm", 0, [
        Head("", ("scapula", s(8, -36, 20)), [u(-20, 20, 45), u(-13, 12, 95)], ("humerus", u(-1, 3, 148))),
    ]),
    Muscle("biceps_brachii", "upper arm", 2, [
        Head("long head", ("scapula", s(-3, -3, 17)),
             [s(18, -8, 27), u(17, 25, 10), u(12, 32, 80), u(9, 38, 160), u(9, 31, 245)], ("radius", f(5, 11, 42)),
             [0.5, 0.5, 0.5, 0.9, 1.0, 0.8, 0.5]),
        Head("short head", ("scapula", s(14, -41, 19)), [u(-10, 30, 62), u(-7, 38, 150), u(1, 32, 240)],
             ("radius", f(4, 10, 48)), [0.5, 0.7, 1.0, 0.8, 0.5]),
    ]),
    Muscle("brachialis", "upper arm", 1, [
        Head("lateral part", ("humerus", u(15, 10, 155)), [u(20, 17, 200), u(14, 22, 255), f(-2, 26, 10)], ("ulna", f(-5, 18, 26))),
        Head("medial part", ("humerus", u(0, 9, 165)), [u(-10, 16, 210), u(-12, 22, 262), f(-11, 26, 12)], ("ulna", f(-11, 18, 28))),
    ]),
    Muscle("triceps_brachii", "upper arm", 1, [
        Head("long head", ("scapula", s(-10, 2, -22)), [u(-24, -20, 75), u(-18, -33, 145), u(-12, -29, 230)],
             ("ulna", f(-11, -24, -14))),
        Head("lateral head", ("humerus", u(14, -8, 58)), [u(26, -22, 105), u(20, -31, 170), u(4, -28, 240)],
             ("ulna", f(-5, -25, -14))),
        Head("medial head", ("humerus", u(4, -8, 168)), [u(-14, -16, 205), u(-16, -18, 250)],
             ("ulna", f(-15, -20, -10))),
    ]),
    Muscle("anconeus", "forearm, extensors", 1, [
        Head("", ("humerus", u(27, -8, 288)), [f(14, -17, 16)], ("ulna", f(-4, -15, 48))),
    ]),
    Muscle("brachioradialis", "forearm, extensors", 2, [
        Head("", ("humerus", u(18, 3, 232)), [u(37, 14, 282), f(37, 24, 40), f(30, 18, 110), f(27, 9, 185)],
             ("radius", f(27, 4, 234)), [0.6, 0.9, 1.0, 0.8, 0.5, 0.45]),
    ]),
    Muscle("extensor_carpi_radialis_longus", "forearm, extensors", 2, [
        Head("", ("humerus", u(24, 2, 262)), [f(43, 6, 12), f(41, 5, 62), f(32, 0, 125), f(26, -9, 200)],
             ("hand", h(17, -4, 36)), [0.6, 0.9, 1.0, 0.6, 0.45, 0.45]),
    ]),
    Muscle("extensor_carpi_radialis_brevis", "forearm, extensors", 2, [
        Head("", ("humerus", u(31, 2, 281)), [f(38, -7, 35), f(34, -9, 85), f(25, -12, 155), f(18, -13, 222)],
             ("hand", h(6, -4, 40)), [0.6, 0.9, 1.0, 0.6, 0.45, 0.45]),
    ]),
    Muscle("extensor_digitorum", "forearm, extensors", 2, [
        Head("", ("humerus", u(32, -3, 286)), [f(32, -18, 55), f(18, -23, 115), f(6, -18, 185), f(3, -15, 236)],
             ("hand", h(6, -6, 78)), [0.6, 0.9, 1.0, 0.6, 0.45, 0.45]),
    ]),
    Muscle("extensor_carpi_ulnaris", "forearm, extensors", 2, [
        Head("", ("humerus", u(29, -7, 290)), [f(17, -25, 55), f(0, -24, 115), f(-15, -17, 185), f(-22, -12, 234)],
             ("hand", h(-19, -4, 36)), [0.6, 0.9, 1.0, 0.6, 0.45, 0.45]),
    ]),
    Muscle("supinator", "forearm, extensors", 0, [
        Head("", ("ulna", f(-2, -12, 32)), [f(9, -12, 40), f(25, -6, 50)], ("radius", f(22, 9, 74))),
    ]),
    Muscle("pronator_teres", "forearm, flexors", 2, [
        Head("", ("humerus", u(-32, 4, 277)), [f(-16, 26, 22), f(6, 23, 72)], ("radius", f(22, 10, 118))),
    ]),
    Muscle("flexor_carpi_radialis", "forearm, flexors", 2, [
        Head("", ("humerus", u(-36, 3, 281)), [f(-28, 27, 45), f(-9, 28, 105), f(10, 18, 185), f(17, 15, 234)],
             ("hand", h(16, 6, 34)), [0.6, 1.0, 1.0, 0.6, 0.45, 0.45]),
    ]),
    Muscle("flexor_digitorum_superficialis", "forearm, flexors", 1, [
        Head("", ("humerus", u(-36, -1, 286)), [f(-24, 14, 65), f(-12, 18, 130), f(0, 14, 215), h(2, 15, 30)],
             ("hand", h(6, 7, 84)), [0.6, 1.0, 1.0, 0.6, 0.45, 0.45]),
    ]),
    Muscle("flexor_carpi_ulnaris", "forearm, flexors", 2, [
        Head("", ("humerus", u(-37, -5, 285)), [f(-39, -2, 50), f(-34, 3, 115), f(-27, 5, 185)],
             ("hand", h(-18, 9, 10)), [0.6, 1.0, 1.0, 0.6, 0.45]),
    ]),
    Muscle("flexor_digitorum_profundus", "forearm, flexors", 0, [
        Head("", ("ulna", f(-15, 4, 45)), [f(-18, 6, 85), f(-12, 7, 150), f(-8, 10, 220), h(-9, 14, 25)],
             ("hand", h(-9, 6, 62)), [0.6, 1.0, 1.0, 0.6, 0.45, 0.45]),
    ]),
    Muscle("pronator_quadratus", "forearm, flexors", 0, [
        Head("proximal part", ("ulna", f(-15, 3, 196)), [f(-1, 6, 198)], ("radius", f(14, 10, 200)), [0.6, 0.6, 0.6]),
        Head("distal part", ("ulna", f(-15, 4, 210)), [f(-1, 7, 212)], ("radius", f(13, 11, 214)), [0.6, 0.6, 0.6]),
    ], anisotropy=(1.0, 0.5, 0.0)),
]
