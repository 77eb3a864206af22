"""Compilation and caching of every kernel in advance.

A kernel is compiled when it is first called with arguments of a kind. What is called here, and with what, is one list,
`_for_order` and the functions below it: to add a way in, give it a line there.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..kernels._cache import CACHE_FOLDER, KernelCache
from ..kernels._notice import CompileNotice
from ..kernels.general.pulleys import tendon_directions
from ..kernels.polynomial import DEGREES
from ..mechanism.mechanism import Mechanism
from ..mechanism.mesh.families import FAMILIES
from ..mechanism.vector import pack
from ..models.equilibrium import Equilibrium
from ..models.finite_element import FiniteElementModel
from ..models.paths.condensed import ORDERS
from ..models.polynomial.model import ForwardPolynomial, PolynomialModel
from ..models.polynomial.training import tip_wrenches
from .sweeps.buffers import ScratchBuffers
from .sweeps.spec_file import read_spec
from .sweeps.statistics import pilot, tally_of

__all__ = ["Warmup", "compilations", "warmup"]

Touch = tuple[str, Callable[[], object]]

_LAM = np.array([[40.0, 10.0], [80.0, 40.0], [0.0, 160.0], [120.0, 30.0]])
_MANY = 2048  # from here on a batch starts from a polynomial


@dataclass(frozen=True)
class Warmup:
    """Result of a warm-up.

    Attributes
    ----------
    seconds : how long it took
    compiled : how many kernels were compiled
    from_cache : how many were found in the cache
    cache : the folder they are kept in, None where there is none: every process then compiles anew
    """

    seconds: float
    compiled: int
    from_cache: int
    cache: Path | None


def warmup(*, everything: bool = False, progress: Callable[[str], None] | None = None) -> Warmup:
    """Compile and keep the kernels that models, batches, control loops, sensitivities, polynomials and sweeps meet.

    These are those of one element of every order that has a fast path, of 20 Lagrange elements of order 1, and of
    polynomials of degree 3; other families, degrees and divisions are compiled when they are met, or by `everything`.
    What this process has loaded already is neither compiled nor looked up again.

    Parameters
    ----------
    everything : elements of every family and polynomials of every degree too
    progress : called with one line of text before every step
    """
    start, before = time.perf_counter(), compilations()
    CompileNotice.given = True  # who calls this knows
    families = tuple(FAMILIES) if everything else ("lagrange",)
    touches = list(_touches(DEGREES if everything else (3,), families))
    for i, (what, touch) in enumerate(touches, start=1):
        if progress is not None:
            progress(f"{i} of {len(touches)}: {what}")
        touch()
    compiled, from_cache = (now - then for now, then in zip(compilations(), before, strict=True))
    return Warmup(time.perf_counter() - start, compiled, from_cache, CACHE_FOLDER)


def compilations() -> tuple[int, int]:
    """Return how many kernels this process has compiled so far, and how many it took from the cache."""
    return KernelCache.compiled, KernelCache.loaded


def _touches(degrees: tuple[int, ...], families: tuple[str, ...]) -> Iterator[Touch]:
    """Yield every way in, by what it is called."""
    neck = Mechanism.preset("slender")
    yield "one solve", lambda: FiniteElementModel(neck).solve((40.0, 10.0))
    for order in ORDERS:
        yield from _for_mesh(f"one element of order {order}", FiniteElementModel(neck, 1, order))
    for family in families:
        yield from _for_mesh(f"20 {family} elements", FiniteElementModel(neck, 20, 1, family=family))
    yield "wrenches of tendons", lambda: tip_wrenches(FiniteElementModel(neck), [[0.1, 0.01, -0.2]], _LAM[:1])
    yield "directions of tendons", lambda: tendon_directions(FiniteElementModel(neck).tip, 0.1, 0.01, -0.2, 1.0)
    for degree in degrees:
        yield from _for_degree(degree)
    yield "control step along a path", lambda: _along_a_path(neck)
    yield "statistics of a sweep", _statistics


def _for_mesh(what: str, model: FiniteElementModel) -> Iterator[Touch]:
    par = np.tile(pack(model.mechanism), (len(_LAM), 1))
    yield f"{what}: one solve", lambda: _all_of(model.solve((40.0, 10.0)))
    yield f"{what}: control step", lambda: model.stepper()(40.0, 10.0)
    yield f"{what}: control step with derivatives", lambda: model.stepper(derivatives=True)(40.0, 10.0)
    yield f"{what}: control step that the general path takes", lambda: model.stepper()(500.0, 480.0)
    yield f"{what}: batch", lambda: model.solve_batch(_LAM)
    yield f"{what}: batch from a polynomial", lambda: model.solve_batch(np.resize(_LAM, (_MANY, 2)))
    yield f"{what}: batch that the general path takes", lambda: model.solve_batch([[500.0, 480.0]])
    yield f"{what}: batch over mechanisms", lambda: model.solve_batch(_LAM, parameters=par)
    yield f"{what}: sensitivities", lambda: model.sensitivities(["EA", "length"], _LAM)


def _all_of(eq: Equilibrium) -> object:
    return eq.q, eq.jacobian, eq.error


def _along_a_path(neck: Mechanism) -> object:
    step = FiniteElementModel(neck.replace(creep=0.01)).stepper()
    step(40.0, 10.0)
    return step.state.hold(neck)


def _statistics() -> object:
    plan = read_spec({"sweep": {"cases": 64}, "inputs": {"lam_l": [0.0, 160.0]}})
    return tally_of(plan, 0, pilot(plan), ScratchBuffers())


def _for_degree(degree: int) -> Iterator[Touch]:
    rng, three = np.random.default_rng(0), np.zeros((3, 3))
    points, values = rng.normal(size=(300, 3)), rng.normal(size=(300, 3))
    poly, forward = PolynomialModel.fit(points, values, degree), ForwardPolynomial.fit(points[:, :2], values, degree)
    yield f"polynomial of degree {degree}: many poses", lambda: (poly.wrench(points), poly.stiffness(points))
    yield f"polynomial of degree {degree}: one pose", lambda: poly.stepper()(0.1, 0.2, 0.3)
    yield f"polynomial of degree {degree}: its slopes", lambda: poly.stepper(slopes=True)(0.1, 0.2, 0.3, three)
    pairs, two = points[:, :2], three[:, :2].copy()
    yield f"forward polynomial of degree {degree}: many", lambda: (forward.pose(pairs), forward.jacobian(pairs))
    yield f"forward polynomial of degree {degree}: one", lambda: forward.stepper()(0.1, 0.2)
    yield f"forward polynomial of degree {degree}: its slopes", lambda: forward.stepper(slopes=True)(0.1, 0.2, two)
