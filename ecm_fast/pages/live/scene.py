"""One frame of the live page: a solve, a polynomial, and the workspace of a changed mechanism."""

import json
import time
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...data.measurements import Measurements
from ...errors import InputError, shown
from ...mechanism.mechanism import Mechanism
from ...mechanism.vector import pack
from ...models.equilibrium import Equilibrium, Status
from ...models.finite_element import FiniteElementModel
from ...models.instruments.history import path_effects
from ...models.instruments.rest_pose import absolute
from ...models.polynomial.model import ForwardPolynomial
from .controls import LAM_MAX, LOADS, checked, controls
from .drawing import outline, rounded

__all__ = ["Scene", "parsed"]

Array = NDArray[np.float64]
_SIDE = 25  # points a side of the grid of tendon forces
_GRID = np.stack(np.meshgrid(*2 * [np.linspace(0.0, LAM_MAX, _SIDE)], indexing="ij"), axis=-1).reshape(-1, 2)
# Gauss-Newton steps towards a place that the head is dragged to
_STEPS = 12
_REQUEST = ("id", "inputs", "wish")


def parsed(text: str | bytes) -> dict[str, Any]:
    """Return a request.

    Raises
    ------
    InputError : it is none.
    """
    if isinstance(text, bytes):
        raise InputError("a request is text, not bytes")
    try:
        request = json.loads(text, parse_constant=_no_number)
    except (ValueError, RecursionError):
        raise InputError(f"{shown(text)} is no JSON") from None
    if not isinstance(request, dict) or not set(request) <= set(_REQUEST):
        raise InputError(f"{shown(request)}: allowed is an object with {', '.join(_REQUEST)}")
    if isinstance(request.get("id"), bool) or not isinstance(request.get("id"), int) or abs(request["id"]) > 2**53:
        raise InputError(f"id = {shown(request.get('id'))}: allowed is a whole number")
    return request


def _no_number(word: str) -> float:
    raise ValueError(word)


class Scene:
    """State of one page; every page, and every thread, has its own."""

    def __init__(self, mechanism: Mechanism, data: Measurements | None = None) -> None:
        mechanism.check_pair("the live page")
        self.mechanism = mechanism
        self.data = None if data is None else absolute(mechanism, data)
        self._changes: Mapping[str, float] | None = None
        self._wrench: tuple[float, ...] | None = None

    def hello(self) -> dict[str, Any]:
        """Return what the page needs once: its sliders, and measurements to lay over the picture."""
        measured: list[Any] = []
        if self.data is not None:
            whole = self.data.measured.all(axis=1)
            measured = rounded(self.data.pose[whole])
        return {
            "controls": [control.json() for control in controls(self.mechanism)],
            "measured": measured,
            "lam_max": LAM_MAX,
        }

    def frame(self, request: Mapping[str, Any]) -> dict[str, Any]:
        """Return what is drawn for a request, see `parsed`.

        Raises
        ------
        InputError : an input is not what it can be.
        """
        start = time.perf_counter()
        inputs = checked(request.get("inputs", {}))
        loads = [inputs.pop(name, 0.0) for name in LOADS]
        lam, wrench = np.array(loads[:2]), tuple(loads[2:])
        fresh = self._prepare(inputs, wrench)
        if "wish" in request:
            lam = self._towards(_place(request["wish"]), lam, wrench)
        before = time.perf_counter()
        eq = self._model.solve(lam, wrench, path="ignore")
        seconds = time.perf_counter() - before
        frame = {
            "id": request["id"],
            "lam": rounded(lam),
            "status": eq.status.name.lower(),
            "stable": eq.stable,
            "message": eq.message + self._left_out,
            "solve_us": 1e6 * seconds,
            "step_us": self._step_us(lam),
            **self._picture(eq, lam),
        }
        if fresh:
            frame["workspace"] = rounded(self._workspace)
        frame["frame_us"] = 1e6 * (time.perf_counter() - start)
        return frame

    def _prepare(self, changes: Mapping[str, float], wrench: tuple[float, ...]) -> bool:
        """Make model, workspace and polynomial where the mechanism or the dead wrench is another; say whether so."""
        if (changes, wrench) == (self._changes, self._wrench):
            return False
        if changes != self._changes:
            self._neck = self.mechanism.replace(**changes)
            self._model = FiniteElementModel(self._neck)
            absent = path_effects(pack(self._neck))
            self._left_out = f"; a page has no order of loads, and leaves out {', '.join(absent)}" if absent else ""
        many = self._model.solve_batch(_GRID, wrench, path="ignore")
        self._workspace = many.pose[many.stable, :2]
        self._step = self._model.stepper(wrench, derivatives=True, path="ignore")
        self._poly = None
        if many.stable.sum() >= _SIDE:
            self._poly = ForwardPolynomial.fit(_GRID[many.stable], many.pose[many.stable]).stepper()
        self._changes, self._wrench = dict(changes), wrench
        return True

    def _picture(self, eq: Equilibrium, lam: Array) -> dict[str, Any]:
        if not eq.converged:
            return {"pose": None, "outline": None, "polynomial": None}
        picture: dict[str, Any] = {"pose": rounded(eq.pose), "outline": outline(self._neck, eq), "polynomial": None}
        if self._poly is not None:
            x, z, theta = self._poly(*lam.tolist())
            picture["polynomial"] = {
                "pose": rounded([x, z, theta]),
                "mm": 1e3 * float(np.hypot(x - eq.x, z - eq.z)),
                "mrad": 1e3 * abs(theta - eq.theta),
            }
        return picture

    def _step_us(self, lam: Array) -> float:
        """Return the time of a control step here, the best of a few: the others were interrupted."""
        left, right = lam.tolist()
        times = []
        for _ in range(5):
            start = time.perf_counter()
            self._step(left, right)
            times.append(time.perf_counter() - start)
        return 1e6 * min(times)

    def _towards(self, wish: Array, lam: Array, wrench: tuple[float, ...]) -> Array:
        """Return tendon forces that bring the head as near to a place as they can: damped Gauss-Newton steps."""
        best, nearest, damping = lam, np.inf, 1e-9
        slopes, gap = np.zeros((2, 2)), np.zeros(2)
        for _ in range(_STEPS):
            x, z, _, status = self._step(*lam.tolist())
            away = wish - (x, z)
            distance = float(away @ away) if status == Status.CONVERGED else np.inf
            if distance < nearest:
                settled = nearest - distance < 1e-14
                best, nearest, slopes, gap = lam, distance, self._step.jacobian[:2].copy(), away
                damping *= 0.3
                if settled:
                    break
            else:
                damping *= 10.0
            if not np.isfinite(nearest):
                break
            lam = _within(best, slopes, gap, damping)
        return best


def _within(lam: Array, slopes: Array, gap: Array, damping: float) -> Array:
    """Return a damped step that stays between no force and the largest; a force at its end does not hold the other."""
    free = np.ones(2, dtype=bool)
    step = np.zeros(2)
    for _ in range(2):
        free_slopes = slopes[:, free]
        step[:] = 0.0
        step[free] = np.linalg.solve(free_slopes.T @ free_slopes + damping * np.eye(free.sum()), free_slopes.T @ gap)
        out = (lam + step < 0.0) & (lam <= 0.0) | (lam + step > LAM_MAX) & (lam >= LAM_MAX)
        if not out.any():
            break
        free &= ~out
        if not free.any():
            return lam
    return np.clip(lam + np.where(free, step, 0.0), 0.0, LAM_MAX)


def _place(wish: object) -> Array:
    given = wish if isinstance(wish, list) and len(wish) == 2 else []
    numbers = [float(value) for value in given if type(value) in (int, float) and abs(value) <= 1e3]
    if len(numbers) != 2:
        raise InputError(f"wish = {shown(wish)}: allowed is a place [x, z] in metres")
    return np.array(numbers)
