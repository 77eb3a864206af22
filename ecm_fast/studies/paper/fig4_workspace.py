"""Fig. 4 of the paper: the workspace of the tip under tendon forces, on both presets."""

import numpy as np
from numpy.typing import NDArray

from ...mechanism.mechanism import Mechanism
from ...mechanism.sections import PRESETS
from ...models.equilibrium import BatchResult
from ...models.finite_element import FiniteElementModel
from ...models.polynomial.training import WRENCH_BOX, tip_wrenches, training_poses
from ...pages.page import Picture, Section
from ...pages.plots import plot_shape, plot_workspace, random_tendon_forces
from .claims import CHANNEL_KEYS, DEG, MM, NOT_GIVEN, UNKNOWN, PaperClaim, Part, by_channel, shown, verdict

__all__ = ["workspace"]

_COVERED = 0.95  # the paper's Fig. 4 is a picture: nineteen of twenty poses must lie in what it shows
# tendon forces [N] of the three shapes that are drawn: rest, one tendon, both
_SHAPES = ((0.0, 0.0), (160.0, 0.0), (40.0, 120.0))
_PLACES = 60  # points of a drawn centerline


def workspace(seed: int = 0, n: int = 1000) -> Part:
    """Solve `n` random pairs of tendon forces on each preset, and as many dead wrenches of the paper's box."""
    lam = random_tendon_forces(n, seed)
    claims, numbers, pictures = [], {}, [_shapes()]
    for preset in PRESETS:
        model = FiniteElementModel(Mechanism.preset(preset))
        result = model.solve_batch(lam)
        covered = _covered(result.pose, training_poses(model, n, seed).poses)
        acting = tip_wrenches(model, result.pose, lam)
        boxed = float(np.mean(((acting >= WRENCH_BOX[0]) & (acting <= WRENCH_BOX[1])).all(axis=1)))
        reach = {name: [column.min(), column.max()] for name, column in by_channel(result.pose).items()}
        stable = int(result.stable.sum())
        numbers[preset] = {"cases": n, "stable": stable, **reach, "covered_share": covered, "boxed_share": boxed}
        claims += [*_claims(preset, result), *_covering(preset, covered, boxed)]
        columns = {"lam_l_N": lam[:, 0], "lam_r_N": lam[:, 1], **by_channel(result.pose)}
        caption = (
            f"Fig. 4, preset {preset}, length {model.mechanism.beam.length * MM:g} mm: poses of the tip for {n} random "
            "pairs of tendon forces, and a close-up."
        )
        pictures.append(Picture(f"workspace_{preset}", caption, plot_workspace(model, n, seed), columns))
    sentences = (
        f"{n} pairs of tendon forces, each force evenly spread over 0 to 160 N. The text of the paper gives no "
        "number for the extent of the workspace, so what is found here has nothing to stand beside.",
    )
    return Part(tuple(claims), numbers, Section("Workspace (Fig. 4)", sentences, pictures=tuple(pictures)))


def _covered(poses: NDArray[np.float64], trained: NDArray[np.float64]) -> float:
    """Return which share of poses (n, 3) lies in the convex hull of others (m, 3)."""
    from scipy.spatial import Delaunay

    middle, size = trained.mean(axis=0), trained.std(axis=0)  # x, z and theta differ by orders of magnitude
    return float(np.mean(Delaunay((trained - middle) / size).find_simplex((poses - middle) / size) >= 0))


def _covering(preset: str, covered: float, boxed: float) -> list[PaperClaim]:
    return [
        PaperClaim(
            f"Section 3, preset {preset}: the training poses cover the workspace, 95 % of it in their convex hull",
            "well",
            f"{covered:.1%}",
            verdict(1.0 - covered, 1.0 - _COVERED, f"{1.0 - covered:.1%} of the workspace outside"),
        ),
        PaperClaim(
            f"Section 3, preset {preset}: the box of wrenches holds what the tendons do at the tip, in 95 % of the "
            "poses of Fig. 4",
            NOT_GIVEN,
            f"{boxed:.1%}",
            verdict(1.0 - boxed, 1.0 - _COVERED, f"{1.0 - boxed:.1%} of the poses outside"),
        ),
    ]


def _claims(preset: str, result: BatchResult) -> list[PaperClaim]:
    lost = len(result) - int(result.stable.sum())
    x, z, theta = result.pose.T
    reach = f"x {_span(x * MM)} mm, z {_span(z * MM)} mm, theta {_span(theta * DEG)} deg"
    return [
        PaperClaim(
            f"Fig. 4, preset {preset}: each of {len(result)} random pairs of tendon forces holds the neck in a pose",
            f"{len(result)} poses",
            f"{len(result) - lost} stable equilibria",
            verdict(lost, 0, f"{lost} poses"),
        ),
        PaperClaim(f"Fig. 4, preset {preset}: extent of the workspace", NOT_GIVEN, reach, UNKNOWN),
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
        dict(zip(("lam_l_N", "lam_r_N", *CHANNEL_KEYS), shapes.T, strict=True)),
    )
