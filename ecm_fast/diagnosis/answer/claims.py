"""Claims: the effects named by a fit, each with size, interval, look-alikes and probability."""

from collections.abc import Mapping

import numpy as np

from ...identification.fit import t_quantile
from ...identification.result import Estimate
from ...mechanism.parameters import find
from ..results.diagnosis import Claim, Model
from ..search.fit import Fit
from ..search.result import Selection

__all__ = ["claims", "estimates"]

LEVEL = 0.90  # of intervals


def estimates(fit: Fit, selection: Selection) -> Mapping[str, Estimate]:
    """Return what calibration moved, by short name, with intervals."""
    count = len(selection.view.problem.keys)
    return {find(key).name: _estimate(fit, i, selection) for i, key in enumerate(fit.keys[:count])}


def _estimate(fit: Fit, i: int, selection: Selection) -> Estimate:
    entry, value, std = find(fit.keys[i]), float(fit.values[i]), float(np.sqrt(fit.covariance[i, i]))
    reach = t_quantile(LEVEL, selection.view.cleaned.dof) * std
    return Estimate(value, std, max(value - reach, entry.lower), min(value + reach, entry.upper), entry.unit)


def claims(selection: Selection, without: Mapping[int, Fit]) -> tuple[Claim, ...]:
    """Return one claim for every effect of the best explanation, in the order of the fits without it, by its place."""
    if not selection.effects:
        return ()
    fit, candidates = selection.best, selection.view.problem.candidates
    models = [model for model in selection.models() if len(model.names) == selection.effects and model.in_set]
    names = tuple(candidates[i].name for i in fit.model)
    answer = []
    for i, rest in without.items():
        candidate = candidates[i]
        keys = {key: fit.keys.index(key) for key in candidate.keys}
        fitted = {find(key).name: _estimate(fit, at, selection) for key, at in keys.items()}
        others, chance = _look_alikes(models, names, fit.model.index(i), selection)
        answer.append(
            Claim(
                name=candidate.name,
                parameters={name: entry.value for name, entry in fitted.items()},
                interval={name: (entry.lower, entry.upper) for name, entry in fitted.items()},
                look_alikes=others,
                mirror=candidate.effect.mirror,
                group=candidate.effect.group,
                sigmas=float(np.sqrt(max(rest.total - fit.total, 0.0))),
                probability=chance,
                times=abs(fit.by_key()[candidate.keys[0]] - candidate.start[0]) / candidate.typical,
                law=_law(fit),
            )
        )
    return tuple(answer)


def _law(fit: Fit) -> str:
    """Return how the law of an effect differs from the catalogue's."""
    if fit.bent > 0.0:
        return f"its law differs from the catalogue's by {fit.bent:.0%} of it, mostly {fit.words}"
    return "seen by a camera that was zeroed at rest" if fit.varied else ""


def _look_alikes(
    models: list[Model], names: tuple[str, ...], place: int, selection: Selection
) -> tuple[tuple[str, ...], float]:
    """Return the names that stand in for one of the best explanation, and that one's own chance."""
    weights = np.exp(-0.5 * np.array([model.behind for model in models]))
    others, unshared = list[str](), 0.0
    for model, weight in zip(models, weights, strict=True):
        if names[place] in model.names:
            unshared += float(weight)
            continue
        new = [name for name in model.names if name not in names]
        stays = [name for name in names if name in model.names]
        others += new if stays else [_nearest(new, names, place, selection)]
    unique = tuple(dict.fromkeys(name for name in others if name))
    return unique, unshared / float(weights.sum())


def _nearest(new: list[str], names: tuple[str, ...], place: int, selection: Selection) -> str:
    """Return which of two new names stands in for the one at `place`."""
    place_of = {candidate.name: i for i, candidate in enumerate(selection.view.problem.candidates)}
    cosine = np.abs(selection.baseline.gram.cosine)
    alike = [cosine[place_of[name], place_of[names[place]]] for name in new]
    return new[int(np.argmax(alike))] if new else ""
