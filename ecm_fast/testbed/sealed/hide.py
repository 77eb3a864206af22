"""Sealed measurements: simulated data with a hidden effect, and its ground truth in another file.

The test bed makes them, another program than the model that is to find the effect.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ...data.measurements import Measurements
from ...errors import InputError, did_you_mean, shown
from ...mechanism.catalogue import CATALOGUE
from ...mechanism.derived import limits
from ...mechanism.mechanism import Mechanism
from ...mechanism.parameters import find
from ...mechanism.quantity import Quantity
from ...mechanism.sections import EFFECT_QUANTITIES, STIFFNESSES
from ...mechanism.vector import pack
from .. import BUILT_IN, OUTSIDE, VARIANTS, Sensors, measure
from .. import design as loads_of
from .ground_truth import Truth

__all__ = ["NOISES", "RANDOM", "Conditions", "conditions", "drawn", "hide"]

Rng = np.random.Generator

RANDOM, RANDOM_OUTSIDE = "random", "random_outside"
"""Names that stand for any effect of the catalogue, and for any that is in none."""

TOLERANCES = {effect.name: effect.size.tolerance for effect in CATALOGUE.values() if effect.size.tolerance}
"""By how much a build differs from its drawing, one standard deviation, in the units of the effects."""
FRAME = {"camera_x_offset": 5e-4, "camera_z_offset": 5e-4, "camera_rotation": 5e-3, "marker_angle_offset": 5e-3}
"""By how much a camera's frame that nobody has aligned is off, one standard deviation."""
_SIZES = (0.5, 2.0)  # of what is typical


@dataclass(frozen=True)
class Conditions:
    """Conditions under which sealed measurements are taken.

    Attributes
    ----------
    sensors : the instruments
    geometry : whether the build differs from its drawing within `TOLERANCES`
    frame : whether the camera's frame is off by `FRAME`
    replicated, replicates : how many loads are applied `replicates` times
    """

    sensors: Sensors = field(default_factory=Sensors)
    geometry: bool = False
    frame: bool = False
    replicated: int = 0
    replicates: int = 1


def _read(**errors: object) -> Callable[[Conditions], Conditions]:
    return lambda now: replace(now, sensors=replace(now.sensors, **errors))  # type: ignore[arg-type]  # fields


NOISES: Mapping[str, Callable[[Conditions], Conditions]] = {
    "white": _read(),
    "none": _read(camera_sigma=(0.0, 0.0, 0.0)),
    "force": _read(force_sigma=0.2),
    "strong_force": _read(force_sigma=0.4),
    "tails": _read(tail_dof=3.0),
    "correlated": _read(correlation=0.3),
    "outliers": _read(outlier_share=0.01),
    "drift": _read(camera_drift=(3e-5, 3e-5, 3e-4), force_drift=(0.05, -0.05)),
    "undeclared": lambda now: replace(now, sensors=replace(now.sensors, declared=False), replicated=10, replicates=5),
    "geometry": lambda now: replace(now, geometry=True),
    "frame": lambda now: replace(now, frame=True),
}
"""Faults of the readings, joined with ``+``; the camera has 0.1 mm, 0.1 mm and 1 mrad in all but ``none``.

Force noise of 0.2 or 0.4 N, Student's t of 3 degrees of freedom, neighboring rows correlated by 0.3, 1 % outliers,
drift below the noise, sigmas that are not said but ten loads applied five times, a build within its tolerances, a
camera whose frame is not known."""


def conditions(noise: str) -> Conditions:
    """Return what a noise's name means, names of `NOISES` joined with ``+``.

    Raises
    ------
    InputError : no such noise.
    """
    found = Conditions()
    for name in noise.split("+"):
        if name not in NOISES:
            raise InputError(f"noise = {shown(name)}: allowed are {', '.join(NOISES)}, joined with +"
                             f"{did_you_mean(name, NOISES)}")  # fmt: skip
        found = NOISES[name](found)
    return found


def hide(
    mechanism: Mechanism | None = None,
    effects: Mapping[str, float | None] | None = None,
    *,
    design: str = "T",
    seed: int = 0,
    noise: str = "white",
    sessions: int = 1,
    spread: bool = True,
    variant: str = "",
) -> tuple[Measurements, Truth]:
    """Make measurements of a mechanism that hides effects.

    Parameters
    ----------
    mechanism : what everybody believes to be built
    effects : names of effects, of their parameters such as ``contact_stop.angle``, or of effects of the test bed that
        no catalogue holds, with their sizes; None draws 0.5 to 2 times the typical size, and the effect's further
        parameters about their defaults. ``random`` and ``random_outside`` stand for any name
    design : what is done, see `testbed.designs`
    seed : a whole number, of everything random
    noise : how it is read, see `NOISES`
    sessions : in how many sessions the first experiment is done
    spread : whether EA, GA and EI differ from those believed, as those of a material test would
    variant : name of a law in the place of the catalogue's, see `testbed.VARIANTS`

    Raises
    ------
    InputError : no such effect, design or noise, or a row has no stable equilibrium.

    Examples
    --------
    >>> data, truth = hide(effects={"precurvature": 0.2}, design="grid3")
    >>> data.n, truth.names
    (9, ('precurvature',))
    """
    neck, taken = mechanism or Mechanism(), conditions(noise)
    of_sizes, of_build, of_loads, of_noise = np.random.default_rng(seed).spawn(4)
    hidden, outside = drawn(effects or {}, of_sizes)
    tolerance = _tolerance(taken, {name.partition(".")[0] for name in hidden}, of_build)
    values = {name: _scattered(neck, name, spread, of_build) for name in STIFFNESSES}
    dimensions = {name: _built(neck, name, off) for name, off in tolerance.items()}
    built = neck.replace(**values, **_keyed(dimensions), **_keyed(hidden))
    loads = loads_of(design, replicated=taken.replicated, replicates=taken.replicates, sessions=sessions, seed=of_loads)
    if variant:
        _check_variant(variant, hidden)
    data = measure(built, loads, taken.sensors, of_noise, hidden={**outside, **({variant: 1.0} if variant else {})})
    truth = Truth(hidden, outside, tolerance, values, design, noise, seed, variant)
    return replace(data, source="sealed measurements"), truth


def _check_variant(variant: str, hidden: Mapping[str, float]) -> None:
    if variant not in VARIANTS:
        raise InputError(f"variant {shown(variant)}: no such law of the test bed{did_you_mean(variant, VARIANTS)}; "
                         f"there are {', '.join(VARIANTS)}")  # fmt: skip
    of = VARIANTS[variant].effects
    if not any(name.partition(".")[0] in of for name in hidden):
        raise InputError(f"variant {variant}: is a law of {' and '.join(of)}; hide one of them")


def _keyed(values: Mapping[str, float]) -> dict[str, float]:
    return {f"effects.{name}": value for name, value in values.items()}


def drawn(effects: Mapping[str, float | None], rng: Rng) -> tuple[dict[str, float], dict[str, float]]:
    """Return parameters of the catalogue and sizes outside of it, with what is not given drawn."""
    inside: dict[str, float] = {}
    outside: dict[str, float] = {}
    for name, value in effects.items():
        kind = _which(name, rng)
        factor = float(rng.uniform(*_SIZES))
        if kind in OUTSIDE:
            outside[kind] = OUTSIDE[kind].typical * factor if value is None else value
        elif kind in CATALOGUE:
            size, *more = CATALOGUE[kind]
            inside[size.name] = _sign(size, rng) * size.typical * factor if value is None else size.check(value)
            if value is None:
                inside |= {entry.name: inside.get(entry.name, _about(entry, rng)) for entry in more}
        elif value is not None:
            inside[kind] = EFFECT_QUANTITIES[kind].check(value)
        else:
            raise InputError(f"{kind}: its value must be given; only sizes of effects are drawn")
    for name in dict.fromkeys(name.partition(".")[0] for name in inside):
        needed = CATALOGUE[name].size.name
        if inside.get(needed, 0.0) == 0.0:
            raise InputError(f"{name}: without a size nothing is hidden; give {needed} a number that is not 0")
    return inside, outside


def _which(name: str, rng: Rng) -> str:
    """Return the name that a name stands for."""
    if name in (RANDOM, RANDOM_OUTSIDE):
        return str(rng.choice([known for known in CATALOGUE if known in BUILT_IN] if name == RANDOM else [*OUTSIDE]))
    short = name.removeprefix("effects.")
    known = [*CATALOGUE, *OUTSIDE, *EFFECT_QUANTITIES, RANDOM, RANDOM_OUTSIDE]
    if short not in known:
        raise InputError(f"effect {shown(name)}: no such effect{did_you_mean(short, known)}")
    return short


def _sign(size: Quantity, rng: Rng) -> float:
    """Either sign where a size is as free below zero as above."""
    return float(rng.choice([-1.0, 1.0])) if size.lower == -size.upper else 1.0


def _about(entry: Quantity, rng: Rng) -> float:
    """Draw a further parameter about its default, within twice what is typical and its bounds."""
    off = float(np.clip(rng.standard_normal(), -2.0, 2.0))
    return float(np.clip(entry.default + off * entry.typical, entry.lower, entry.upper))


def _tolerance(taken: Conditions, hidden: set[str], rng: Rng) -> dict[str, float]:
    """Draw how the build and the camera's frame are off, where no effect is hidden there."""
    off = {name: sigma * float(rng.standard_normal()) for name, sigma in (TOLERANCES | FRAME).items()}
    used = {**(TOLERANCES if taken.geometry else {}), **(FRAME if taken.frame else {})}
    return {name: off[name] for name in used if name not in hidden}


def _built(neck: Mechanism, name: str, off: float) -> float:
    """Return what is there of an effect where the build is `off`, as far as that can be."""
    return float(np.clip(neck.effects.get(name, 0.0) + off, *limits(f"effects.{name}", pack(neck))))


def _scattered(neck: Mechanism, name: str, spread: bool, rng: Rng) -> float:
    """Return a stiffness as it is, which a material test would know to its own scatter."""
    off = float(rng.standard_normal()) * spread
    entry = find(name)
    return float(getattr(neck.beam, name)) * (1.0 + off * entry.typical / entry.default)
