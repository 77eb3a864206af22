"""Published cantilever measurements: steel without a free parameter, silicone with one modulus."""

from typing import Any

import numpy as np
from scipy.optimize import brentq

from ...data.datasets import describe, load
from ...data.measurements import Measurements
from ...mechanism.mechanism import Mechanism
from ...models.instruments.prediction import Prediction, predict
from ...pages.page import Picture, Section, Table
from ...pages.plots import plot_residuals
from .claims import DEG, MM, PaperClaim, Part, shown, verdict

__all__ = ["fitted_modulus", "silicone", "square_section", "steel"]

_SIDE = 0.030
"""[m] of the silicone beam's square section."""
_STEEL_BOUND = 0.007  # share of the length: the bound that the claim states
_SAG_BOUND, _ROTATION_BOUND = 0.10, 1.0  # share, and degrees: bounds that the claims state


def steel() -> Part:
    """Predict seven deflections of a steel strip from its drawing alone."""
    name = "steel_cantilever"
    mechanism, data = load(name)
    prediction = predict(mechanism, data)
    misfit = float(np.abs(prediction.residual[:, 1]).max())
    share = misfit / mechanism.beam.length
    claim = PaperClaim(
        "Steel strip bent to 70 % of its length by a weight: without any fitted number the model meets all seven "
        "measured deflections to 0.7 % of the length",
        f"{-data.z.max() * MM:.0f} to {-data.z.min() * MM:.0f} mm, read to 1 mm",
        f"largest misfit {shown(misfit * MM, '.1f')} mm, {shown(share, '.2%')} of the length",
        verdict(share, _STEEL_BOUND, f"{shown(share, '.2%')} of the length"),
    )
    numbers = {"rows": prediction.rows, "rms": prediction.rms, "largest_misfit_m": misfit, "share_of_length": share}
    picture = _picture(name, "Steel cantilever, z of the tip", prediction)
    return Part((claim,), numbers, Section("Steel cantilever", (describe(name),), pictures=(picture,)))


def silicone() -> Part:
    """Fit one modulus to the sag under own weight, then predict the rows with a mass hung on the tip."""
    name = "silicone_cantilever"
    mechanism, data = load(name)
    modulus = fitted_modulus(mechanism, data)
    prediction = predict(square_section(mechanism, modulus), data)
    rows = [
        {"extra_mass_kg": mass, "sag_m": [-z, -pose[1]], "theta_rad": [theta, pose[2]]}
        for mass, z, theta, pose in zip(data.extra_mass, data.z, data.theta, prediction.pose, strict=True)
    ]
    table = Table(
        f"One modulus, {modulus / 1e6:.4f} MPa, from the sag under the beam's own weight",
        ("hung mass [g]", "sag measured [mm]", "predicted [mm]", "rotation measured [deg]", "predicted [deg]"),
        tuple(
            (1e3 * row["extra_mass_kg"], *(MM * v for v in row["sag_m"]), *(DEG * v for v in row["theta_rad"]))
            for row in rows
        ),
    )
    picture = _picture(name, "Silicone cantilever, z and rotation of the tip", prediction)
    sentences = (
        describe(name),
        "One modulus does not explain both: with the modulus that meets the sag under the beam's own weight, the "
        "measured tip turns more than the model lets it, and the more so the larger the load. This is a real "
        "disagreement between the beam model and a beam, and it is shown as it is.",
    )
    section = Section("Silicone cantilever", sentences, (table,), (picture,))
    claims = tuple(claim for row in rows[1:] for claim in _silicone_claims(row))
    return Part(claims, {"modulus_Pa": modulus, "rms": prediction.rms, "rows": rows}, section)


def square_section(mechanism: Mechanism, modulus: float) -> Mechanism:
    """Return the silicone beam with Young's `modulus` [Pa]: Poisson ratio 0.5, shear factor 5/6, both assumed."""
    area, shear_modulus = _SIDE**2, modulus / 3.0
    return mechanism.replace(EA=modulus * area, GA=5.0 / 6.0 * shear_modulus * area, EI=modulus * _SIDE**4 / 12.0)


def fitted_modulus(mechanism: Mechanism, data: Measurements) -> float:
    """Return the modulus [Pa] at which the first row, the beam under its own weight, sags as measured."""
    row = data.select([0])
    return float(brentq(lambda E: predict(square_section(mechanism, E), row).residual[0, 1], 1e5, 1e6, xtol=0.1))


def _silicone_claims(row: dict[str, Any]) -> list[PaperClaim]:
    (sag, sags), (angle, angles) = row["sag_m"], row["theta_rad"]
    where = f"Silicone beam with {1e3 * row['extra_mass_kg']:.0f} g hung on its tip, modulus from its own weight alone"
    off, turned = sags / sag - 1.0, (angles - angle) * DEG
    return [
        PaperClaim(
            f"{where}: sag within 10 %",
            f"{sag * MM:.1f} mm",
            f"{shown(sags * MM, '.1f')} mm, {shown(off, '+.1%')}",
            verdict(abs(off), _SAG_BOUND, shown(off, "+.1%")),
        ),
        PaperClaim(
            f"{where}: rotation of the tip within 1 deg, by which two runs differ",
            f"{angle * DEG:.1f} deg",
            f"{shown(angles * DEG, '.1f')} deg",
            verdict(abs(turned), _ROTATION_BOUND, f"{shown(turned, '+.1f')} deg; one modulus does not explain it"),
        ),
    ]


def _picture(name: str, what: str, prediction: Prediction) -> Picture:
    caption = f"{what}: measured against predicted, and what is left below."
    return Picture(name, caption, plot_residuals(prediction), prediction.columns())
