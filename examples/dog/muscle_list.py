"""Which muscles the hind limb has: by their anatomical names, head by head, with the artist's file behind each.

An end is a bone and the attachment site on it (the site's name in attachment_sites.csv, or coordinates where that
table has none). "edge" is the cut plane where the region of interest ends, "free" is no anchor at all.
"""
import dataclasses
from typing import Optional


@dataclasses.dataclass
class End:
    bone: str
    site: Optional[str] = None
    which: int = 0  # of several patches on one bone
    at: Optional[tuple] = None  # [m], instead of a site

    def __post_init__(self):
        self.site = self.site or self.bone


@dataclasses.dataclass
class Head:
    name: str
    file: str
    start: End
    end: End
    points: int = 5
    strip: int = 0  # of `strips` side by side: a sheet
    strips: int = 1
    sites: Optional[str] = None  # the file that the site table names instead
    crop: Optional[float] = None  # only the artist's mesh in front of this X [m]
    via: Optional[tuple] = None  # shifts the middle of the path [m]
    path: Optional[tuple] = None  # inner points given outright [m]
    belly: Optional[tuple] = None  # (share of the length, tissue value) pairs, instead of what the mesh's radius says


@dataclasses.dataclass
class Muscle:
    name: str
    group: str
    layer: int
    heads: list
    value: float = 1.0
    anisotropy: Optional[tuple] = None  # λ₂, λ₃, rotation [°]
    kind: str = "muscle"


PELVIS, FEMUR, TIBIA, FIBULA, PATELLA = "Pelvis", "Femoris_L", "Tibia_L", "Fibula_L", "Patella_L"
CALCANEUS = "Calcaneal_tuber_L"


def one(name, group, layer, file, start, end, points=5, **more):
    """A muscle of one curve."""
    muscle = {k: more.pop(k) for k in ("value", "anisotropy", "kind") if k in more}
    return Muscle(name, group, layer, [Head("", file, start, end, points, **more)], **muscle)


def sheet(name, group, layer, file, starts, ends, strip_names, points=5, **more):
    """A flat muscle: curves side by side, from the cranial border to the caudal one."""
    heads = [
        Head(n, file, start, end, points, strip=k, strips=len(strip_names), **more)
        for k, (n, start, end) in enumerate(zip(strip_names, starts, ends))
    ]
    return Muscle(name, group, layer, heads)


MUSCLES = [
    # Rump
    sheet("gluteus_superficialis", "rump", 2, "MUSCm.gluteus_superficialis_major_L.stl",
          [End("Sacrum"), End("Ca_1")], [End(FEMUR)] * 2, ["cranial part", "caudal part"], 4),
    sheet("gluteus_medius", "rump", 1, "MUSCm.gluteus_medius_L.stl",
          [End(PELVIS)] * 2, [End(FEMUR)] * 2, ["dorsal part", "ventral part"], 4),
    one("gluteus_profundus", "rump", 0, "MUSCm.gluteus_profundus_minor_L.stl", End(PELVIS), End(FEMUR), 4),
    one("tensor_fasciae_latae", "rump", 2, "MUSCm_tensor_f.latae_L.stl", End(PELVIS),
        End("free", "vastus_lat_ander_fascia_lata_L"), 4),  # ends in the fascia lata, which we do not have
    one("obturatorius_internus", "hip", 0, "MUSCm.obturatorius_int_L.stl", End(PELVIS), End(FEMUR), 4,
        via=(0, 0.01, 0)),  # round the ischium in a bend, not in a kink at the median plane
    one("obturatorius_externus", "hip", 0, "MUSCm.obturatorius_ext_L.stl", End(PELVIS), End(FEMUR), 4),
    one("gemelli", "hip", 0, "MUSCm.gemellus_L.stl", End(PELVIS), End(FEMUR), 4),
    one("quadratus_femoris", "hip", 0, "MUSCm.quadratus_femoris_L.stl", End(PELVIS), End(FEMUR), 4),
    # Loin
    one("iliacus", "loin", 0, "MUSCm.iliacus_L.stl", End(PELVIS), End(FEMUR), 4),
    one("psoas_major", "loin", 0, "MUSCm.psoas_major_L.stl", End("edge"), End(FEMUR)),
    one("psoas_minor", "loin", 0, "MUSCm.psoas_minor_L.stl", End("edge"), End(PELVIS), 4),
    one("longissimus_lumborum", "loin", 1, "MUSCm.longissimus_capitis_L.stl", End("edge"),
        End(PELVIS, at=(-0.2330, 0.0270, 0.5190)), 4),
    # Thigh, caudal
    sheet("biceps_femoris", "thigh", 2, "MUSCm_biceps_femoris_L.stl", [End(PELVIS)] * 3,
          [End(PATELLA), End(TIBIA), End(TIBIA)], ["cranial part", "middle part", "caudal part"]),
    one("semitendinosus", "thigh", 2, "MUSCm.semitendinosus_L.stl", End(PELVIS), End(TIBIA)),
    Muscle("semimembranosus", "thigh", 1, [
        Head("cranial belly", "MUSCm.semimembranosus_L.stl", End(PELVIS), End(FEMUR, at=(-0.3500, 0.0660, 0.3270)),
             strip=0, strips=2),
        Head("caudal belly", "MUSCm.semimembranosus_L.stl", End(PELVIS), End(TIBIA, at=(-0.3640, 0.0640, 0.2860)),
             strip=1, strips=2),
    ]),
    # Thigh, medial
    sheet("gracilis", "thigh", 2, "MUSCm.gracilis_L.stl", [End(PELVIS)] * 2, [End(TIBIA)] * 2,
          ["cranial part", "caudal part"]),
    sheet("adductor_magnus", "thigh", 1, "MUSCm.adductor_magnus_L.stl", [End(PELVIS)] * 2, [End(FEMUR)] * 2,
          ["cranial part", "caudal part"], 4),
    one("adductor_longus", "thigh", 0, "MUSCm.adductor_longus_L.stl", End(PELVIS), End(FEMUR), 4),
    one("pectineus", "thigh", 1, "MUSCm.pectineus_L.stl", End(PELVIS), End(FEMUR), 4),
    Muscle("sartorius", "thigh", 2, [
        Head("cranial part", "MUSCm.sartorius_L(2).stl", End(PELVIS, which=0), End(PATELLA),
             sites="MUSCm.sartorius_L.stl"),
        Head("caudal part", "MUSCm.sartorius_L.stl", End(PELVIS, which=1), End(TIBIA)),
    ]),
    # Thigh, cranial: the four heads of the quadriceps
    one("rectus_femoris", "quadriceps", 1, "MUSCm.rectus_femoris_L.stl", End(PELVIS), End(PATELLA)),
    one("vastus_lateralis", "quadriceps", 1, "MUSCm.vastus_lat_L.stl", End(FEMUR), End(PATELLA)),
    one("vastus_medialis", "quadriceps", 1, "MUSCm.vastus_med_L.stl", End(FEMUR), End(PATELLA)),
    one("vastus_intermedius", "quadriceps", 0, "MUSCm.vastus_intermedius_L.stl", End(FEMUR), End(PATELLA)),
    # Crus, caudal
    Muscle("gastrocnemius", "crus", 2, [
        Head("medial head", "MUSCm.gastrocnemius_L.stl", End(FEMUR, "Femoris_L1"), End(CALCANEUS), strip=0, strips=2),
        Head("lateral head", "MUSCm.gastrocnemius_L.stl", End(FEMUR, "Femoris_L2"), End(CALCANEUS), strip=1, strips=2),
    ]),
    one("flexor_digitorum_superficialis", "crus", 1, "MUSCm.flexor_digitorum_superficialis_L.001.stl",
        End(FEMUR, at=(-0.3460, 0.0870, 0.3210)), End(CALCANEUS, at=(-0.5430, 0.0790, 0.1920))),
    one("flexor_digitorum_profundus", "crus", 0, "MUSCm.flexor_digitorum_profundus_L(2).stl",
        End(TIBIA, "Tibia_L1"), End("Metatarsi_L_2", at=(-0.5460, 0.0730, 0.0850)),
        sites="MUSCm.flexor_digitorum_profundus_L.stl",
        path=((-0.411, 0.078, 0.262), (-0.473, 0.072, 0.222), (-0.529, 0.066, 0.181), (-0.548, 0.067, 0.150),
              (-0.552, 0.070, 0.120))),
    one("popliteus", "crus", 0, "MUSCm.popliteus_L.stl", End(FEMUR), End(TIBIA), 4),
    # Crus, cranial and lateral
    one("tibialis_cranialis", "crus", 2, "MUSCm.tibialis_cranialis_L.stl", End(FIBULA), End("Tarsus_central_L")),
    one("extensor_digitorum_longus", "crus", 1, "MUSCm.extensor_digitorum_longus_L.stl", End(FEMUR),
        End("Phalanges_B_3_L_2"), 7, belly=((0, 0.5), (0.15, 0.9), (0.3, 1.0), (0.45, 0.6), (0.6, 0.45), (1, 0.45))),
    one("extensor_digitorum_lateralis", "crus", 1, "MUSCm.extensor_digitorum_lateralis_L.stl",
        End(FIBULA, at=(-0.4300, 0.0930, 0.2530)),
        End("Phalanges_B_L_4"), 6),
    one("peroneus_longus", "crus", 2, "MUSCm.peroneus_longus_L.stl", End(FIBULA), End("Tarsus_L_IV", at=(-0.5480, 0.0960, 0.1240)), 6),
    one("peroneus_brevis", "crus", 0, "MUSCm.peroneus_brevis_L.stl", End(FIBULA),
        End("Metatarsi_L_4", at=(-0.5490, 0.1010, 0.1000))),
    # Root of the tail
    one("coccygeus", "tail", 0, "MUSCm.coccygeus_L.stl", End(PELVIS), End("Ca_3"), 4),
    one("levator_ani", "tail", 0, "MUSCm.levator_ani_L.stl", End(PELVIS), End("Ca_4"), 4),
    one("sacrocaudalis_dorsalis_lateralis", "tail", 1, "MUSCm.levator_caudae_longus_L.stl", End("edge"), End("Ca_8"), 6,
        crop=-0.412),
    # Belly
    sheet("rectus_abdominis", "belly", 1, "MUSCm.rectus_abdominis_L.stl", [End("edge")] * 2, [End(PELVIS)] * 2,
          ["medial part", "lateral part"], 4),
    # What fills the belly and the pelvic canal, so that the muscles around have something to press against
    Muscle("viscera", "belly", 0, [
        Head("dorsal", "", End("edge"), End("free"),
             path=((-0.2, 0.022, 0.457), (-0.240, 0.020, 0.452), (-0.280, 0.015, 0.452), (-0.318, 0.012, 0.464))),
        Head("ventral", "", End("edge"), End("free"),
             path=((-0.2, 0.022, 0.425), (-0.235, 0.020, 0.430), (-0.268, 0.018, 0.438))),
    ], kind="filler"),
]
