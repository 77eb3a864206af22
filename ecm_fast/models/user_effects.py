"""User-defined effects: a law in a few lines, added at run time.

>>> import numpy as np
>>> import ecm_fast as ecm
>>> @ecm.effect("cable_drag", unit="N m", typical=0.5, enters="head", law="tau - a sin(theta)", mirror="even")
... def cable_drag(a, x, z, theta):
...     return 0.0, 0.0, -a * np.sin(theta)
>>> neck = ecm.Mechanism.preset("slender").replace(cable_drag=0.4)
>>> ecm.FiniteElementModel(neck).solve((40.0, 10.0)).stable
True
>>> ecm.remove_effect("cable_drag")
"""

import inspect
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

import numpy as np

from ..errors import InputError, did_you_mean, why
from ..files import read_whole
from ..kernels.layout import N_USER
from ..kernels.user_laws import LAWS, MOST_LAWS, N_LAW
from ..mechanism.catalogue import CATALOGUE, Effect, Mirror, declare
from ..mechanism.parameters import N_BUILT_IN, PARAMETERS, append, find, index, remove
from ..mechanism.quantity import Quantity
from ..mechanism.vector import tail
from .instruments.history import USER_ROWS

__all__ = ["effect", "load_effects", "make_effects", "remove_effect", "sources"]

Law = Callable[..., Any]
_ENTERS: dict[str, Any] = {"section": "section", "head": "environment", "rows": "path"}
_LAWS: dict[str, dict[str, Law]] = {"section": {}, "head": {}}
_COORDINATES = {"section": 4, "head": 3}  # that a law depends on: strains and place, or the pose
_ALIVE: list[Any] = []  # compiled laws, whose addresses are in the kernels' table for good
_ADDRESSES = {"section": 0, "head": 0}
_LOADED: dict[str, str] = {}  # the text of files of effects, by the names they were run under
_PROBES = np.array([[0.96, 0.01, 3.0, 0.3], [1.02, -0.02, -2.0, 0.8], [0.9, 0.03, 0.5, 0.6]])
_SYMMETRY = 1e-9  # share of the tangent by which rounding may break its symmetry


def effect(
    name: str,
    *more: Quantity,
    unit: str,
    typical: float,
    enters: Literal["section", "head", "rows"],
    bounds: tuple[float, float] | None = None,
    law: str = "",
    meaning: str = "an effect added by the user",
    mirror: Mirror = "mixed",
    group: str = "user",
    size: str = "size",
    needs: Sequence[str] = (),
    tolerance: float = 0.0,
) -> Callable[[Law], Law]:
    """Add an effect: a decorator of its law, which then takes part in everything as those of the catalogue do.

    Parameters
    ----------
    name : a word of small letters and underscores, in no use yet
    more : further parameters, made by `ecm_fast.also`; their values follow the size in the law's arguments
    unit, typical, bounds, law, meaning, mirror, group, size, needs, tolerance : see `ecm_fast.Effect` and
        `ecm_fast.Quantity`; default bounds are a hundred times the typical size
    enters : what the law is given behind the values, and returns

        ``section``  gamma_x, gamma_z, kappa, place (share of the length); adds N, Q, M
        ``head``     x, z, theta of the head; adds f_x, f_z, tau
        ``rows``     a `Rows`; a mapping from parameters to what is added to them, row by row

    Laws of section and head are compiled, for complex numbers: arithmetic and NumPy's functions of one number; a case
    is decided by ``.real``, and ``kappa**3`` must be a product (a complex power is a logarithm, which rounds the
    imaginary part of a negative number). They must derive from an energy: the tangent must be symmetric.

    Raises
    ------
    InputError : the name is taken or no name, there are too many, the law does not vanish with its size, or its
        tangent is not symmetric (with the two numbers that should be equal).
    """

    def register(function: Law) -> Law:
        bound = bounds or (-100.0 * typical, 100.0 * typical)
        entry = declare(
            name, law or f"see {name}", unit, meaning, *more, typical=typical, bounds=bound, enters=_ENTERS[enters],
            group=group, mirror=mirror, size=size, needs=tuple(needs), tolerance=tolerance,
        )  # fmt: skip
        _check_name(entry)
        _check_scales(entry)
        append(entry)
        try:
            if enters == "rows":
                USER_ROWS[name] = function
            else:
                _LAWS[enters][name] = function
                _compile(enters)
                _check_law(entry, enters)
            _enter()
        except Exception:
            remove_effect(name)
            raise
        return function

    if enters not in _ENTERS:
        raise InputError(f"enters = {enters!r}: allowed is {', '.join(_ENTERS)}{did_you_mean(enters, _ENTERS)}")
    return register


def remove_effect(name: str) -> None:
    """Take an effect that was added by `effect` away again.

    Raises
    ------
    InputError : no effect of that name was added.
    """
    if name not in {**USER_ROWS, **_LAWS["section"], **_LAWS["head"]}:
        raise InputError(f"{name!r} is no effect that was added")
    remove(CATALOGUE[name])
    USER_ROWS.pop(name, None)
    for enters, laws in _LAWS.items():
        laws.pop(name, None)
        _compile(enters)  # places have moved
    _enter()


def load_effects(path: str | os.PathLike[str]) -> None:
    """Run a Python file that adds effects. Its text goes with a sweep to workers, which then know them too.

    Raises
    ------
    InputError : the file cannot be read, or fails; names it and why.
    """
    try:
        text = read_whole(path).decode("utf-8-sig")
    except (OSError, ValueError) as error:
        raise InputError(f"{os.fspath(path)}: cannot be read ({why(error)})") from None
    _run(text, os.fspath(path))


def sources() -> dict[str, str]:
    """Return what makes each added effect, by its name: the text of the file that was loaded, else that of its law."""
    laws = {**USER_ROWS, **_LAWS["section"], **_LAWS["head"]}
    return {name: _source(laws[name]) for name in CATALOGUE if name in laws}


def make_effects(added: Mapping[str, str]) -> None:
    """Add the effects of `sources` that this process does not know yet.

    Raises
    ------
    InputError : one cannot be made here, since its law was not defined in a file that was loaded; or another of the
        same name is known already.
    """
    known = sources()
    for name, text in added.items():
        if known.get(name, text) != text:
            raise InputError(f"effect {name!r} is another one here; start this worker anew")
        if name not in CATALOGUE:
            _run(text, f"the source of effect {name!r}")
        if name not in CATALOGUE:
            raise InputError(f"effect {name!r} is not known here; define it in a file for load_effects or --plugin")


def _source(law: Law) -> str:
    code: Any = law.__code__
    if code.co_filename in _LOADED:
        return _LOADED[code.co_filename]
    try:
        return inspect.getsource(law)
    except OSError:  # typed at a prompt
        return f"# {code.co_code.hex()} {code.co_consts!r}"


def _run(text: str, name: str) -> None:
    _LOADED[name] = text
    try:
        exec(compile(text, name, "exec"), {"__name__": "ecm_fast_plugin", "__file__": name})
    except InputError as error:
        raise InputError(f"{name}: {error}") from None
    except (Exception, SystemExit) as error:
        raise InputError(f"{name}: {type(error).__name__}: {error}") from None


def _check_name(effect: Effect) -> None:
    words = effect.name.split("_")
    if not all(word.isascii() and word.isalnum() and word.islower() for word in words) or effect.name[0].isdigit():
        raise InputError(f"effect {effect.name!r}: a name has small letters, digits and single underscores")
    if effect.name in CATALOGUE or any(entry.name == effect.name for entry in PARAMETERS):
        raise InputError(f"effect {effect.name!r} exists already; take another name")
    used = len(PARAMETERS) - N_BUILT_IN
    if used + len(effect.quantities) > N_USER:
        raise InputError(f"effect {effect.name!r}: {N_USER} parameters can be added, {used} are in use")


def _check_scales(effect: Effect) -> None:
    typical, tolerance = effect.size.typical, effect.size.tolerance
    if not 0.0 < typical < np.inf:
        raise InputError(f"effect {effect.name!r}: typical = {typical!r}: allowed is a finite number above 0")
    if not 0.0 <= tolerance < np.inf:
        raise InputError(f"effect {effect.name!r}: tolerance = {tolerance!r}: allowed is a finite number from 0 on")


def _compile(enters: str) -> None:
    """Compile one C function that adds up all laws that enter at one place, and note its address."""
    import numba

    laws, first = _LAWS[enters], N_BUILT_IN
    if not laws:
        _ADDRESSES[enters] = 0
        return
    coordinates = [f"given[{N_USER + i}]" for i in range(_COORDINATES[enters])]
    lines = [
        "def added(inputs, outputs):",
        f"    given, found = carray(inputs, ({N_USER + 4},)), carray(outputs, (3,))",
        "    found[0], found[1], found[2] = 0j, 0j, 0j",
    ]
    for i, name in enumerate(laws):
        values = [f"given[{index(entry.key) - first}]" for entry in CATALOGUE[name]]
        lines.append(f"    a, b, c = law{i}({', '.join([*values, *coordinates])})")
        lines.append("    found[0], found[1], found[2] = found[0] + a, found[1] + b, found[2] + c")
    options: Any = {"error_model": "numpy"}
    names: dict[str, Any] = {f"law{i}": numba.njit(**options)(law) for i, law in enumerate(laws.values())}
    names["carray"] = numba.carray  # type: ignore[attr-defined]  # numba is untyped
    exec("\n".join(lines), names)
    numbers: Any = numba.types.CPointer(numba.types.complex128)  # type: ignore[no-untyped-call]  # numba is untyped
    function: Any = numba.cfunc(numba.types.void(numbers, numbers))(names["added"])
    _ALIVE.append(function)
    _ADDRESSES[enters] = function.address


def _enter() -> None:
    """Add the laws that there are now to the kernels' table, under the digest of their names."""
    if not (digest := tail()).size:
        return
    entry = int(LAWS[0]) + 1
    if entry > MOST_LAWS:
        raise InputError(f"effects were added or removed {MOST_LAWS} times: no more can be in one process")
    LAWS[N_LAW * entry : N_LAW * (entry + 1)] = digest[0], _ADDRESSES["section"], _ADDRESSES["head"]
    LAWS[0] = entry


def _check_law(effect: Effect, enters: str) -> None:
    """Refuse a law that does not vanish with its size or has no energy."""
    law, rest = _ALIVE[-1], [entry.default for entry in effect.quantities[1:]]
    for probe in _PROBES:
        forces = _evaluate(law, effect, [0.0, *rest], probe)
        if np.any(forces != 0.0):
            raise InputError(f"effect {effect.name!r}: its law gives {forces.real} where its size is 0; it must vanish")
        columns = [
            _evaluate(law, effect, [effect.size.typical, *rest], probe + 1e-100j * unit) for unit in np.eye(4)[:3]
        ]
        tangent = np.array(columns).imag.T * 1e100
        gap = np.abs(tangent - tangent.T)
        i, k = np.unravel_index(np.argmax(gap), gap.shape)
        if not gap[i, k] <= _SYMMETRY * np.abs(tangent).max():
            raise InputError(f"effect {effect.name!r}: derivatives {tangent[i, k]:g} and {tangent[k, i]:g} of forces "
                             f"{i + 1} and {k + 1} must be equal: a law needs an energy, and powers above the second "
                             "written as products")  # fmt: skip


def _evaluate(law: Any, effect: Effect, values: Sequence[float], coordinates: Any) -> Any:
    """Return what the compiled law gives, (3,) complex, with the effects of the user but for one absent."""
    given, found = np.zeros(N_USER + 4, dtype=complex), np.zeros(3, dtype=complex)
    for entry in PARAMETERS[N_BUILT_IN:]:
        given[index(entry.key) - N_BUILT_IN] = find(entry.key).default
    for entry, value in zip(effect, values, strict=True):
        given[index(entry.key) - N_BUILT_IN] = value
    given[N_USER:] = coordinates
    law.ctypes(given.ctypes.data, found.ctypes.data)
    return found
