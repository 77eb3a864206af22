"""Robots of the tables `guided_planar` and `guided_planar_lengths`, whose comments define the columns."""

import math

import numpy as np

from ecm_fast.mechanism.body import Marker, Segment, Tendon
from ecm_fast.mechanism.mechanism import Mechanism
from ecm_fast.mechanism.sections import Beam, Gravity, Head

__all__ = ["arc", "closed_arc", "pose_of", "robot", "sizes", "tendon_numbers"]


def tendon_numbers(row) -> list[int]:
    """Return which of the four tendons a row has."""
    return [i for i in range(1, 5) if row[f"t{i}_s_end"] != ""]


def robot(row) -> Mechanism:
    """Return the mechanism of a row, tendons called t1 to t4, markers m1 and m2."""
    length, g = row["L"], math.hypot(row["gx"], row["gz"])
    segment = Segment(
        length=length,
        EA_start=row["EA"],
        GA_start=row["GA"],
        EI_start=row["EI"],
        mass_per_length_start=row["rhoA"],
        taper=row["tip_ratio"],
    )
    tendons = []
    for i in tendon_numbers(row):
        base, tip, end = (row[f"t{i}_{name}"] for name in ("z_base", "z_end", "s_end"))
        tendons.append(
            Tendon(
                name=f"t{i}",
                route="guided",
                points=2.0,
                place_1=0.0,
                offset_1=base,
                place_2=end,
                offset_2=tip,
                ends_at=end if end < 0.999 * length else 0.0,
                compliance=row.get(f"t{i}_compliance") or 0.0,
            )
        )
    markers = [
        Marker(name=f"m{i}", place=row[f"m{i}_s"], offset_z=row[f"m{i}_z"]) for i in (1, 2) if row[f"m{i}_s"] != ""
    ]
    return Mechanism(
        beam=Beam(axial_law=row["law"]),
        head=Head(mass=row["mH"], h=row["h"], b=row["b"]),
        gravity=Gravity(g=g, tilt=math.atan2(-row["gz"], -row["gx"]) if g else 0.0),
        segments=(segment,),
        named_tendons=tuple(tendons),
        markers=tuple(markers),
    )


def sizes(row) -> np.ndarray:
    """Return what errors of x, z and theta are measured in: the length, and 1 rad."""
    return np.array([row["L"], row["L"], 1.0])


def pose_of(row, point: str) -> np.ndarray:
    """Return the pose of the tip, or of a marker."""
    names = ("x_L", "z_L", "theta_L") if point == "tip" else (f"{point}_x", f"{point}_z_pos", f"{point}_theta")
    return np.array([row[name] for name in names])


def arc(**changes) -> Mechanism:
    """Return a rod that weighs nothing, with one parallel tendon 10 mm beside its axis."""
    segment = Segment(length=0.24, EA_start=2000.0, GA_start=700.0, EI_start=0.02)
    tendon = Tendon(name="t", route="guided", points=1.0, offset_1=0.01, **changes)
    return Mechanism(
        beam=Beam(axial_law="hooke"), head=Head(0.0, 0.0, 0.0), gravity=Gravity(0.0), segments=(segment,),
        named_tendons=(tendon,),
    )  # fmt: skip


def closed_arc(force: float) -> tuple[np.ndarray, float]:
    """Return pose and tendon length of `arc`: kappa = -lam o/EI, N(g) = -lam, whatever the shear stiffness."""
    kappa, stretch = -force * 0.01 / 0.02, 1.0 - force / 2000.0
    turn = 0.24 * kappa
    return np.array([stretch * math.sin(turn) / kappa, stretch * (math.cos(turn) - 1.0) / kappa, turn]), 0.24 * (
        stretch + 0.01 * kappa
    )
