"""Where tendon forces can take the tip: the paper's Fig. 4, on both presets."""

import numpy as np
from numpy.typing import NDArray

from ..equilibrium import BatchResult
from ..mechanism import PRESETS, Mechanism
from ..model import FiniteElementModel
from ..plots import plot_shape, plot_workspace, random_tendon_forces
from ..report import Picture, Section
from ._claim import CHANNELS, DEG, MM, NOT_GIVEN, Claim, Part, by_channel, shown, verdict

__all__ = ["workspace"]

_CASES, _SEED = 1000, 4
_SHAPES = ((0.0, 0.0), (160.0, 0.0), (40.0, 120.0))
_PLACES = 60


def workspace() -> Part:
    """Solve 1000 random pairs of tendon forces on each preset."""
    lam = random_tendon_forces(_CASES, _SEED)
    claims, numbers, pictures = [], {}, [_shapes()]
    for preset in PRESETS:
        model = FiniteElementModel(Mechanism.preset(preset))
        result = model.solve_batch(lam)
        reach = {name: [column.min(), column.max()] for name, column in by_channel(result.pose).items()}
        numbers[preset] = {"cases": _CASES, "stable": int(result.stable.sum()), **reach}
        claims += _claims(preset, result)
        columns = {"lam_l_N": lam[:, 0], "lam_r_N": lam[:, 1], **by_channel(result.pose)}
        caption = (
            f"Preset {preset}, length {model.mechanism.beam.length * MM:g} mm: poses of the tip for {_CASES} random "
            "pairs of tendon forces."
        )
        pictures.append(Picture(f"workspace_{preset}", caption, plot_workspace(model, _CASES, _SEED), columns))
    sentences = (
        f"{_CASES} pairs of tendon forces, each force evenly spread over 0 to 160 N. The text of the paper gives no "
        "number for the extent of the workspace, so what is found here has nothing to stand beside.",
    )
    return Part(tuple(claims), numbers, Section("Workspace (Fig. 4)", sentences, pictures=tuple(pictures)))


def _claims(preset: str, result: BatchResult) -> list[Claim]:
    lost = len(result) - int(result.stable.sum())
    x, z, theta = result.pose.T
    reach = f"x {_span(x * MM)} mm, z {_span(z * MM)} mm, theta {_span(theta * DEG)} deg"
    return [
        Claim(
            f"Fig. 4, preset {preset}: each of {_CASES} random pairs of tendon forces holds the neck in a pose",
            f"{_CASES} poses",
            f"{len(result) - lost} stable equilibria",
            verdict(lost, 0, f"{lost} poses"),
        ),
        Claim(f"Fig. 4, preset {preset}: extent of the workspace", NOT_GIVEN, reach, "cannot be checked"),
    ]


def _span(values: NDArray[np.float64]) -> str:
    return f"{shown(values.min(), '.2f')} to {shown(values.max(), '.2f')}"


def _shapes() -> Picture:
    model = FiniteElementModel(Mechanism.preset("slender"))
    equilibria = [model.solve(lam).raise_if_failed() for lam in _SHAPES]
    loads = np.repeat(_SHAPES, _PLACES, axis=0)
    shapes = np.column_stack([loads, np.concatenate([eq.shape(_PLACES) for eq in equilibria])])
    forces = ", ".join(f"({left:g}, {right:g}) N" for left, right in _SHAPES)
    return Picture(
        "shapes",
        f"Preset slender under left and right tendon forces of {forces}: centerline, head plate, tendons, and the "
        "head's center of mass.",
        plot_shape(model, equilibria),
        dict(zip(("lam_l_N", "lam_r_N", *CHANNELS), shapes.T, strict=True)),
    )
