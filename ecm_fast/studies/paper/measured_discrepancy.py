"""The model discrepancy of the silicone cantilever: a diagnosis of its six readings."""

import math
from dataclasses import replace

import numpy as np

from ...data.datasets import load
from ...data.measurements import Measurements
from ...diagnosis import Diagnosis
from ...diagnosis.design.next_loads import Pool, fitted_rivals, next_loads
from ...diagnosis.search.result import LIMITS
from ...mechanism.catalogue import CATALOGUE
from ...mechanism.mechanism import Mechanism
from ...pages.page import Section, Table
from ..diagnosis import diagnose
from .claims import MM, UNKNOWN, PaperClaim, Part, shown
from .measured_cantilevers import fitted_modulus, square_section

__all__ = ["missing"]

_NOISE = 4e-4, 4e-4, math.radians(0.45)
"""Half of what two runs differ by [m, m, rad]; x was not read."""
_ROUGHLY = 0.2
"""Share by which EA and GA may be off what one modulus gives, one standard deviation."""
_WEIGHED = {"head_mass": 3e-4}
"""Hung masses are given to the gram: known to 0.3 g, one standard deviation; the neck's own tolerance is no guide."""
_THERE = ("section", "clamp", "plate", "environment", "camera")
"""Parts of the model that an effect can enter: there are no tendons, no force cells, and no record of time."""
_RIVALS = 3  # explanations shown beside the best
# [kg, rad] loads of the proposed experiment, within the reach of a bench
_MASSES, _TILTS = (0.0, 0.1, 0.2, 0.3), (math.pi / 2, math.pi / 4, 0.0)


def missing() -> Part:
    """Ask what six readings of three loads can say, what they cannot, and what to measure next."""
    mechanism, data = load("silicone_cantilever")
    mechanism = square_section(mechanism, fitted_modulus(mechanism, data))
    x, z, theta = (np.full(data.n, sigma) for sigma in _NOISE)
    data = replace(data, sigma_x=x, sigma_z=z, sigma_theta=theta)
    priors = {name: (getattr(mechanism.beam, name), _ROUGHLY * getattr(mechanism.beam, name)) for name in ("EA", "GA")}
    names = [name for name, effect in CATALOGUE.items() if effect.enters in _THERE]
    answer = diagnose(mechanism, data, candidates=names, uncertain=_WEIGHED, priors=priors)
    nearest = [model for model in answer.models if len(model.names) == 1][:_RIVALS]
    table = Table(
        "Explanations by one effect each, EA, GA and EI fitted with it, the best first",
        ("effect", "size", "unit", "behind the best (2 log evidence)", "cannot be told from it"),
        tuple(
            (model.names[0], model.sizes[0], CATALOGUE[model.names[0]].size.unit, model.behind, str(model.in_set))
            for model in nearest
        ),
    )
    planned = _next(mechanism, data, [model.names for model in nearest], priors)
    sentences = (
        "Asked what the beam model misses here, with half of what two runs differ by as noise, the diagnosis answers: "
        f"{answer.sentence}",
        "That is a hint and no finding. Six readings under three loads leave no row aside to prove it on; x was not "
        "read; effects of tendons, force cells and time were not asked for, since there were none. An effect behind "
        f"the best by less than {LIMITS[1]:g} could not be told from it.",
        planned,
    )
    claim = PaperClaim(
        "What the beam model misses on the silicone beam, from six readings of three loads",
        "not given",
        _short(answer),
        f"{UNKNOWN}: no row is left to prove it on",
    )
    numbers = {"verdict": answer.verdict, "sentence": answer.sentence, "effects": [_short(answer)], "next": planned}
    return Part((claim,), numbers, Section("Silicone cantilever: what is missing?", sentences, (table,)))


def _short(answer: Diagnosis) -> str:
    if not answer.effects:
        return answer.verdict.replace("_", " ")
    first = answer.effects[0]
    size = first.parameters[CATALOGUE[first.name].size.name]
    others = f", or {', '.join(first.look_alikes)}" if first.look_alikes else ""
    what = f"{shown(size * MM, '.1f')} mm" if CATALOGUE[first.name].size.unit == "m" else f"{size:.3g}"
    return f"{first.name} {what}, {first.sigmas:.1f} sigma{others}"


def _next(
    mechanism: Mechanism,
    data: Measurements,
    sets: list[tuple[str, ...]],
    priors: dict[str, tuple[float, float]],
) -> str:
    """Say which hung masses and tilts of the clamp would tell the explanations apart."""
    loads = np.zeros((len(_MASSES) * len(_TILTS), 7))
    loads[:, 5], loads[:, 6] = np.repeat(_MASSES, len(_TILTS)), np.tile(_TILTS, len(_MASSES))
    rivals = fitted_rivals(mechanism, [data], sets, priors=priors)
    found = next_loads(rivals, [data], sigma=_NOISE, priors=priors, pool=Pool(loads, ("mass",) * len(loads)))
    steps = "; ".join(
        f"{entry.loads.get('extra_mass_kg', 0.0) * 1e3:.0f} g with the beam {math.degrees(tilt):.0f} deg off upright"
        for entry in found.suggestions
        for tilt in (entry.loads.get("tilt_rad", 0.0),)
    )
    apart = found.suggestions[-1].promised_sigma if found.suggestions else found.worst_before
    return (
        f"What to measure next, x beside z and rotation, three readings each: {steps}. The explanations of the table, "
        f"{found.worst_before:.1f} sigma apart now, would then be {apart:.1f} apart."
    )
