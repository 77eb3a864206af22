"""Hostile input: a right answer, or one line of error, in bounded work."""

import contextlib
import io
import json
import tempfile
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from hypothesis import HealthCheck, assume, example, given, settings
from hypothesis import strategies as st

from ecm_fast.cli import main
from ecm_fast.errors import InputError
from ecm_fast.kernels.general.newton import MAX_ITERATIONS, MAX_LOAD_STEPS
from ecm_fast.mechanism.derived import limits
from ecm_fast.mechanism.mechanism import Mechanism
from ecm_fast.mechanism.mesh.discretization import Discretization
from ecm_fast.mechanism.parameters import PARAMETERS, PLACES, find
from ecm_fast.mechanism.quantity import Quantity
from ecm_fast.mechanism.sections import AXIAL_LAWS, SECTIONS
from ecm_fast.mechanism.vector import pack, unpack
from ecm_fast.models import reference
from ecm_fast.models.equilibrium import Equilibrium, Status
from ecm_fast.models.finite_element import FiniteElementModel

pytestmark = pytest.mark.slow

EPS = float(np.finfo(np.float64).eps)
# one try at full load and five walks of load steps, each with at most so many Newton steps: no load makes a solve hang
MOST_STEPS = MAX_ITERATIONS * (1 + 5 * MAX_LOAD_STEPS)
slow_uncompiled = pytest.mark.skipif(
    bool(numba.config.DISABLE_JIT), reason="takes minutes with kernels that are not compiled"
)


def hostile(examples: int) -> settings:
    return settings(
        max_examples=examples,
        deadline=None,
        derandomize=True,
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
    )


@pytest.fixture(scope="module", autouse=True)
def _compiled() -> None:
    """Compile first, so that no example is slow for that."""
    for elements in (1, 2):
        for order in range(1, 7):
            model = FiniteElementModel(elements=elements, order=order)
            model.solve((40.0, 10.0))
            model.solve_batch([(40.0, 10.0)])


def one_line(error: InputError, start: str = "") -> None:
    assert str(error)
    assert str(error).startswith(start)
    assert len(str(error).splitlines()) == 1


# Mechanisms


def values(entry: Quantity) -> st.SearchStrategy[Any]:
    """Draw any allowed value, often a bound, often one near the default."""
    if entry.key == "beam.axial_law":
        return st.sampled_from(AXIAL_LAWS)
    usual = entry.default or entry.typical
    near = st.floats(-3.0, 3.0).map(lambda power: min(max(usual * 10.0**power, entry.lower), entry.upper))
    ends = st.sampled_from([entry.lower, entry.upper, entry.default])
    return st.one_of(near, ends, st.floats(entry.lower, entry.upper))


def built(changes: dict[str, Any]) -> Mechanism:
    """Return a mechanism with changes, each as far as the others leave it possible."""
    neck = Mechanism().replace(**{key: value for key, value in changes.items() if not key.startswith("effects.")})
    last = "effects.bonded_ends.size"  # what is possible of it depends on several others
    for key in sorted((key for key in changes if key.startswith("effects.")), key=lambda key: key == last):
        lower, upper = limits(key, pack(neck))
        neck = neck.replace(**{key: min(max(changes[key], lower), upper)})
    return neck


CHANGES = {entry.key: values(entry) for entry in PARAMETERS[: len(PLACES)]}
mechanisms = st.fixed_dictionaries({}, optional=CHANGES).map(built)
every_value = st.fixed_dictionaries(CHANGES).map(built)
meshes = st.one_of(st.just((1, 6)), st.tuples(st.integers(1, 3), st.integers(1, 6)))
numbers = st.one_of(
    st.floats(-4.0, 4.0).map(lambda power: 10.0**power), st.floats(), st.sampled_from([0.0, -0.0, 1e300])
)
signed = st.one_of(numbers, numbers.map(lambda number: -number))
tensions = st.one_of(numbers, signed)


@hostile(150)
@given(every_value)
def test_any_mechanism_goes_to_a_file_and_to_a_vector_and_back(neck: Mechanism) -> None:
    """Round trip: every digit, for random mechanisms."""
    with tempfile.TemporaryDirectory() as folder:
        neck.to_toml(Path(folder) / "neck.toml")
        again = Mechanism.from_toml(Path(folder) / "neck.toml")
    assert again == neck == unpack(pack(neck))
    assert pack(again).tobytes() == pack(unpack(pack(neck))).tobytes() == pack(neck).tobytes()


# Files

words = st.sampled_from([*SECTIONS, "effects", "preset", *(part for e in PARAMETERS for part in e.key.split("."))])
keys = st.one_of(words, words, st.text(max_size=5))
leaves = st.one_of(
    st.floats(),
    st.integers(),
    st.integers(-(10**400), 10**400),
    st.booleans(),
    st.text(max_size=8),
    st.sampled_from([*AXIAL_LAWS, "slender", "paper"]),
    st.dates(),
    st.times(),
)
trees = st.dictionaries(
    keys,
    st.recursive(
        leaves, lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(keys, inner, max_size=4))
    ),
    max_size=4,
)


def toml(value: Any) -> str:
    if isinstance(value, dict):
        return (
            "{"
            + ", ".join(f"{json.dumps(key, ensure_ascii=False)} = {toml(entry)}" for key, entry in value.items())
            + "}"
        )
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    if isinstance(value, (bool, str)):
        return json.dumps(value, ensure_ascii=False)
    return str(value)


def check_file(content: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "neck.toml"
        path.write_bytes(content)
        try:
            assert isinstance(Mechanism.from_toml(path), Mechanism)
        except InputError as error:
            one_line(error, f"{path}: ")


@hostile(300)
@given(trees)
def test_any_tree_as_a_mechanism_file(tree: dict[str, Any]) -> None:
    """Contract: a mechanism or one line of error, for random TOML."""
    text = "\n".join(f"{json.dumps(key, ensure_ascii=False)} = {toml(value)}" for key, value in tree.items())
    check_file(text.encode("utf-8", "surrogatepass"))


@hostile(200)
@given(st.one_of(st.binary(), st.text().map(lambda text: text.encode("utf-8", "surrogatepass"))))
def test_any_bytes_as_a_mechanism_file(content: bytes) -> None:
    """Contract: a mechanism or one line of error, for random bytes."""
    check_file(content)


@hostile(120)
@given(st.data())
def test_a_good_file_with_damage(data: st.DataObject) -> None:
    """Contract: a mechanism or one line of error, for a file with changed bytes."""
    with tempfile.TemporaryDirectory() as folder:
        data.draw(mechanisms).to_toml(Path(folder) / "neck.toml")
        content = bytearray((Path(folder) / "neck.toml").read_bytes())
    for place, byte in data.draw(
        st.dictionaries(st.integers(0, len(content) - 1), st.integers(0, 255), max_size=4)
    ).items():
        content[place] = byte
    check_file(bytes(content[: data.draw(st.integers(0, len(content)))]))


# Solves: finite and converged, or not a number and a status that says so, or an InputError


def answered(pose: Any, status: Status) -> None:
    assert np.isfinite(pose).all() if status.converged else np.isnan(pose).all()


@slow_uncompiled
@hostile(250)
@given(mechanisms, meshes, tensions, tensions, signed, signed, signed)
def test_any_mechanism_under_any_load(
    neck: Mechanism, mesh: tuple[int, int], lam_l: float, lam_r: float, fx: float, fz: float, tau: float
) -> None:
    """Contract: a finite pose with a good status, or nan with a bad one, or one line of error."""
    lam, wrench = (lam_l, lam_r), (fx, fz, tau)
    finite, pulls = bool(np.isfinite([*lam, *wrench]).all()), not (lam_l < 0.0 or lam_r < 0.0)
    model = FiniteElementModel(neck, *mesh)
    try:
        eq = model.solve(lam, wrench, path="ignore")
    except InputError as error:
        one_line(error)
        assert not (finite and pulls)
    else:
        assert finite
        assert pulls
        answered(eq.pose, eq.status)
        assert 0.0 <= eq.load_factor <= 1.0
        assert eq.iterations <= MOST_STEPS
        assert np.isfinite(eq.compliance).all() or not eq.converged
        assert eq.message
        assert np.isfinite(eq.shape(3)).all()
    try:
        batch = model.solve_batch([lam, (1.0, 2.0)], [wrench, (0.0, 0.0, 0.0)], path="ignore")
    except InputError as error:
        one_line(error)
        assert not pulls
    else:
        assert pulls
        assert finite or Status(batch.status[0]) is Status.INVALID_INPUT
        for pose, status in zip(batch.pose, batch.status, strict=True):
            answered(pose, Status(status))


@slow_uncompiled
@hostile(100)
@given(st.lists(st.floats(), min_size=len(PARAMETERS), max_size=len(PARAMETERS)), st.integers(0, len(PARAMETERS) - 1))
def test_any_numbers_as_the_parameters_of_a_batch(par: list[float], place: int) -> None:
    """Contract: one line of error, or rows that answer for themselves."""
    one_wrong = pack(Mechanism())
    one_wrong[place] = par[place]
    model = FiniteElementModel()
    try:
        batch = model.solve_batch(np.full((3, 2), 10.0), parameters=[par, one_wrong, pack(Mechanism())])
    except InputError as error:
        one_line(error)
    else:
        for pose, status in zip(batch.pose, batch.status, strict=True):
            answered(pose, Status(status))
        assert batch.converged[2]
        assert batch.converged[:2].tolist() <= np.isfinite([par, one_wrong]).all(axis=1).tolist()


@pytest.mark.parametrize("loads", [("a", 1.0), (1.0,), (1.0,) * 4, 1.0, (1j, 1.0), ((1.0, 2.0), (3.0,))], ids=repr)
def test_loads_that_cannot_be(loads: Any) -> None:
    """Contract: one line of error at every way in."""
    model = FiniteElementModel()
    for call in (model.solve, model.solve_batch, lambda wrench: model.solve((1.0, 1.0), wrench)):
        with pytest.raises(InputError) as caught:
            call(loads)
        one_line(caught.value)


@pytest.mark.parametrize(
    "elements",
    [0, -1, 100_001, 10**400, "a", None, float("nan"), [], [1.0, -1.0], [1.0, float("nan")], [[1.0]], {}, 1j],
    ids=lambda elements: repr(elements)[:20],
)
def test_elements_that_cannot_be(elements: Any) -> None:
    """Contract: one line of error."""
    with pytest.raises(InputError) as caught:
        Discretization.from_elements(elements)
    one_line(caught.value)


@pytest.mark.parametrize("elements", [[1e308, 1e308], [1e-320, 1.0], [1e-12, 1.0], [1.0, 1e300]], ids=repr)
def test_elements_of_extreme_lengths(elements: list[float]) -> None:
    """Contract: an answer with its status, or one line of error."""
    try:
        eq = FiniteElementModel(elements=elements).solve((40.0, 10.0))
    except InputError as error:
        one_line(error)
    else:
        answered(eq.pose, eq.status)


@pytest.mark.parametrize("order", [0, 7, -1, 2.5, float("nan"), "6", [1, 2], np.array([1, 2])], ids=repr)
def test_orders_that_cannot_be(order: Any) -> None:
    """Contract: one line of error."""
    with pytest.raises(InputError) as caught:
        Discretization.from_elements(1, order)
    one_line(caught.value)


# Equilibria: what is claimed to be one is one


@st.composite
def loaded_necks(draw: st.DrawFn) -> tuple[Mechanism, tuple[float, float], tuple[float, float, float]]:
    """Draw necks of any size and stiffness, under loads that matter to them."""
    length, EI = 10.0 ** draw(st.floats(-6.0, 6.0)), 10.0 ** draw(st.floats(-12.0, 15.0))
    unit, part = EI / length**2, st.floats(-1.0, 1.0)
    stiff = st.floats(0.0, 8.0).map(lambda power: unit * 10.0**power)
    changes = {
        **{"length": length, "EI": EI, "EA": draw(stiff), "GA": draw(stiff)},
        **{"mass_per_length": unit / length * abs(draw(part)), "head.mass": unit * abs(draw(part)), "g": draw(part)},
        **{name: length * draw(part) for name in ("h", "b", "pulley_x", "pulley_z", "pulley_shift")},
        **{"plate_half_width": length * abs(draw(part)), "pulley_radius": 0.1 * length * abs(draw(part))},
        **{"precurvature": draw(part) / length, "neutral_axis_offset": 0.1 * length * draw(part)},
        **{"clamp_tilt": draw(part), "gravity_tilt": draw(part)},
    }
    always = {"length", "EI", "EA", "GA", "mass_per_length", "head.mass"}
    kept = always | draw(st.sets(st.sampled_from(list(changes))))
    allowed = {name: float(np.clip(changes[name], find(name).lower, find(name).upper)) for name in sorted(kept)}
    neck = Mechanism().replace(axial_law=draw(st.sampled_from(AXIAL_LAWS)), **allowed)
    size = unit * 10.0 ** draw(st.floats(-3.0, 1.5))
    lam = (size * max(0.0, draw(part)), size * max(0.0, draw(part)))
    return neck, lam, (size * draw(part), size * draw(part), size * length * draw(part))


def out_of_balance(p: dict[str, float], mesh: Discretization, loads: Any, q: Any) -> tuple[float, float]:
    """Return how far `q` is from an equilibrium, by the dense reference: in rounding errors, and in pose.

    The first number compares the residual of each coordinate with what rounding alone may leave there,
    eps (|K| |q| + |loads at the tip|): a coordinate is known to eps |q| at best, and the tangent K makes force of it.
    For the stiffest beams that is far more than the loads, and no solver in double precision gets below it.
    The second is Newton's step from `q`, the error in the pose: in rad, and in shares of the length or of the
    displacement if that is larger.
    """
    K, res = reference.tangent(p, mesh, loads, q), reference.residual(p, mesh, loads, q)
    sizes = np.zeros(q.size)
    for i in range(6):
        alone = np.where(np.arange(6) == i, loads, 0.0)
        sizes[-3:] += np.abs(reference.tip_wrench(p, alone, q[-3:]))
    rounding = EPS * (np.abs(K) @ np.abs(q) + sizes)
    with np.errstate(divide="ignore", invalid="ignore"):
        in_rounding = np.nanmax(np.where(res == 0.0, 0.0, np.abs(res) / rounding)[3:])
    size = max(p["beam.length"], np.abs(q.reshape(-1, 3)[:, :2]).max())
    scale = np.tile([size, size, 1.0], q.size // 3)
    return float(in_rounding), float(np.max(np.abs(reference.newton_step(p, mesh, loads, q)) / scale))


def check_equilibrium(model: FiniteElementModel, lam: Any, wrench: Any, eq: Equilibrium) -> None:
    p, mesh, loads = reference.named(pack(model.mechanism)), eq.discretization, np.array([*lam, *wrench, 1.0])
    with np.errstate(invalid="ignore", divide="ignore"):
        if not np.isfinite(reference.tip_wrench(p, loads, eq.q[-3:])).all():
            return  # a slack tendon inside its pulley: nothing times nothing
    rounding, distance = out_of_balance(p, mesh, loads, eq.q)
    assert rounding < 1e3 or distance < 1e-8
    if p["beam.axial_law"] == 0.0:
        assert smallest_stretch(p, mesh, eq.q) > 0.0
    slenderness = max(p["beam.EA"], p["beam.GA"]) * reference.length(p) ** 2 / p["beam.EI"]
    if EPS * slenderness > 1e-7:
        return  # the contact force, known to eps EA, is no better known than the buckling load
    held = [p[f"effects.clamp_{name}_compliance"] == 0.0 for name in ("axial", "lateral", "rotation")]
    free = np.flatnonzero(~np.array([*held, *np.zeros(eq.q.size - 3, bool)]))
    K = reference.tangent(p, mesh, loads, eq.q)[np.ix_(free, free)]
    scale = 1.0 / np.sqrt(np.abs(np.diag(K)))
    lowest = np.linalg.eigvalsh(K * np.outer(scale, scale))[0]
    if abs(lowest) < 1e-8:
        return  # at a limit point
    assert eq.stable == (lowest > 0.0)
    section = (scale[:, None] * np.linalg.inv(K * np.outer(scale, scale)) * scale)[-3:, -3:]
    turn, yields = head_on_section(p, loads, eq.q[-3:])
    compliance = turn @ section @ turn.T + yields
    size = np.sqrt(np.abs(np.diag(compliance)))
    assert np.max(np.abs(eq.compliance - compliance) / np.outer(size, size)) < 1e-5


def head_on_section(p: dict[str, float], loads: Any, pose: Any) -> tuple[Any, Any]:
    """Return derivatives of the head's pose by the tip section's, and by a wrench on it while the section stands."""
    steps = 1e-30j * np.eye(3)
    by_pose = [reference.head_pose(p, loads, pose + step).imag * 1e30 for step in steps]
    by_wrench = [reference.head_pose(p, loads + np.array([0, 0, *step, 0]), pose + 0j).imag * 1e30 for step in steps]
    return np.array(by_pose).T, np.array(by_wrench).T


def smallest_stretch(p: dict[str, float], mesh: Discretization, q: Any) -> float:
    """Return the smallest stretch where the neo-Hookean law is evaluated: below 0 the material is turned inside out."""
    found = []
    for e, share in enumerate(mesh.shares):
        x, z, theta = q[3 * e * mesh.order :][: 3 * (mesh.order + 1)].reshape(-1, 3).T
        h = share * reference.length(p)
        for shape, slope in zip(*mesh.basis, strict=True):
            dr, turn = np.array([slope @ x, slope @ z]) / h, slope @ theta / h
            gamma_x, _, kappa = reference.section_strains(dr, shape @ theta, turn)
            found.append(gamma_x + p["effects.neutral_axis_offset"] * kappa)
    return float(min(found))


STIFF_IN_SHEAR = Mechanism().replace(length=1.0, EA=1.0, GA=1e6, EI=1.0, mass_per_length=0.0, **{"head.mass": 0.0})


@slow_uncompiled
@hostile(300)
@given(loaded_necks(), meshes)
@example((STIFF_IN_SHEAR, (0.0, 0.0), (0.0, 1.0, 0.0)), (1, 1))  # the compliance had lost eleven digits
def test_a_claimed_equilibrium_is_one(case: Any, mesh: tuple[int, int]) -> None:
    """Reference in NumPy: residual and tangent at the claimed solution, for random cases."""
    neck, lam, wrench = case
    model = FiniteElementModel(neck, *mesh)
    eq = model.solve(lam, wrench)
    assert eq.iterations <= MOST_STEPS
    answered(eq.pose, eq.status)
    if eq.converged:
        check_equilibrium(model, lam, wrench, eq)
    batch, step = model.solve_batch([lam], [wrench]), model.stepper(wrench)
    x, z, theta, status = step(*lam)
    assert batch.status[0] == eq.status
    # NOT_CONVERGED: what one call of a step does not finish; `followed`: it may be on a branch of its own
    assert status in (eq.status, Status.NOT_CONVERGED) or step.followed
    size = max(neck.beam.length, abs(eq.x), abs(eq.z))
    # a neck that its own weight buckles has mirror images, of which a step may have followed the other one
    step_counts = status == Status.CONVERGED and eq.preload_factor == 1.0 and not step.followed
    for pose in (batch.pose[0], *([np.array([x, z, theta])] if step_counts else [])):
        assert np.allclose(pose / [size, size, 1.0], eq.pose / [size, size, 1.0], rtol=0.0, atol=1e-7, equal_nan=True)


@slow_uncompiled
@hostile(150)
@given(mechanisms, meshes, numbers, numbers, signed, signed, signed)
def test_a_claimed_equilibrium_is_one_under_any_load(
    neck: Mechanism, mesh: tuple[int, int], lam_l: float, lam_r: float, fx: float, fz: float, tau: float
) -> None:
    """Reference in NumPy: residual and tangent at the claimed solution, for loads of any size."""
    loads = np.array([lam_l, lam_r, fx, fz, tau])
    assume(np.isfinite(loads).all() and lam_l >= 0.0 and lam_r >= 0.0)
    model = FiniteElementModel(neck, *mesh)
    eq = model.solve(loads[:2], loads[2:], path="ignore")
    if eq.converged:
        check_equilibrium(model, loads[:2], loads[2:], eq)


@slow_uncompiled
@hostile(100)
@given(mechanisms, meshes, st.lists(st.tuples(tensions, tensions), max_size=4))
def test_any_tensions_in_a_control_loop(
    neck: Mechanism, mesh: tuple[int, int], loop: list[tuple[float, float]]
) -> None:
    """Contract: an answer with its status at every step, and a good one afterwards."""
    model = FiniteElementModel(neck, *mesh)
    for step in (model.stepper(), model.stepper(path="ignore")):
        for lam in [*loop, (0.0, 0.0)]:
            *pose, status = step(*lam)
            answered(pose, Status(status))
            if not (np.isfinite(lam).all() and min(lam) >= 0.0):
                assert not Status(status).converged
    assert Status(status).converged or not model.solve((0.0, 0.0), path="ignore").stable


@pytest.mark.parametrize("curvature", [1.0, -9.0, 10.0, -20.0, 50.0, 100.0])
@pytest.mark.parametrize("mesh", [(1, 5), (4, 3)])
def test_a_beam_cast_as_an_arc_stays_one(curvature: float, mesh: tuple[int, int]) -> None:
    """Closed form: without load the tip angle is length times curvature."""
    neck = Mechanism().replace(precurvature=curvature, mass_per_length=0.0, **{"head.mass": 0.0})
    eq = FiniteElementModel(neck, *mesh).solve((0.0, 0.0))
    assert eq.stable
    assert eq.theta == pytest.approx(0.109 * curvature, rel=1e-9)


@slow_uncompiled
@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("power", range(3, 16))
def test_a_claimed_equilibrium_is_one_under_a_colossal_load(axis: int, power: int) -> None:
    """Reference in NumPy: residual and tangent, under loads up to 1e300."""
    model = FiniteElementModel()
    for sign in (1.0, -1.0):
        wrench = np.zeros(3)
        wrench[axis] = sign * 10.0**power
        eq = model.solve((0.0, 0.0), wrench)
        answered(eq.pose, eq.status)
        if eq.converged:
            check_equilibrium(model, (0.0, 0.0), wrench, eq)


@slow_uncompiled
def test_a_fine_mesh_that_finds_no_equilibrium_gives_up() -> None:
    """Contract: a bounded number of Newton steps."""
    eq = FiniteElementModel(elements=400, order=6).solve((0.0, 0.0), (0.0, 0.0, 3e4))
    assert eq.iterations <= MOST_STEPS
    answered(eq.pose, eq.status)


# The command line

vocabulary = st.sampled_from(
    ["solve", "predict", "effects", "init", "--tendons", "--wrench", "--mechanism", "--elements", "--order", "--json",
     "--out", "--force", "--preset", "--help", "-h", "--version", "--", "-", "0", "1", "2", "40", "-5e1", "-.5", "nan",
     "inf", "-inf", "1e400", "5e-324", "7", "0x10", "1_0", "slender", "paper", "run.csv", "neck.toml", "x", "..", "",
     "--tendons=1", "--out=", "@run.csv"]
)  # fmt: skip
plain_text = st.text(st.characters(exclude_characters="/\\~"), max_size=5)  # no path that leaves the folder
arguments = st.one_of(
    st.lists(st.one_of(vocabulary, vocabulary, vocabulary, plain_text), max_size=8),
    st.tuples(st.just("solve"), st.just("--tendons"), vocabulary, vocabulary, vocabulary, vocabulary).map(list),
)


@slow_uncompiled
@hostile(400)
@given(arguments)
def test_any_arguments(words: list[str]) -> None:
    """Contract: an exit code and lines on stderr, never a traceback."""
    out, err = io.StringIO(), io.StringIO()
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        Path("run.csv").write_text("lam_l_N,lam_r_N\n40,10\n5000,0\n")
        Path("neck.toml").write_text("[beam]\nEI = 2.0\n")
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = main(words)
    assert code in (0, 2, 3)
    lines = err.getvalue().splitlines()
    assert all(line.startswith("ecm-fast: ") for line in lines)
    if code == 2:
        assert len(lines) == 1
        assert out.getvalue() == ""
    elif "--json" in words and not {"--help", "-h", "--version"} & set(words):
        assert isinstance(json.loads(out.getvalue(), parse_constant=pytest.fail), dict)


# Every way in, with forces that are none or far too many: a status or one error, and the next good call is right


IMPOSSIBLE = [np.nan, np.inf, -np.inf, -1.0, -1e300]
COLOSSAL = [1e9, 1e154, 1e300, float(np.finfo(float).max)]
WAYS = {"condensed": (1, 5), "chain": (20, 1), "chain of quadratics": (3, 2)}
GOOD = np.random.default_rng(6).uniform(0.0, 160.0, (70, 2))


def spoiled_rows(column: int) -> tuple[Any, Any, list[int]]:
    """Return 70 good loads, and the same with bad numbers in one column (two of forces, three of the wrench)."""
    lam, wrench, rows = GOOD.copy(), np.zeros((70, 3)), []
    for i, value in enumerate([*IMPOSSIBLE[:3], *COLOSSAL, *(-number for number in COLOSSAL)]):
        if column < 2 and value < 0.0:
            continue  # refused for the whole batch
        (lam if column < 2 else wrench)[7 * i % 70 + i // 10, column % 2 if column < 2 else column - 2] = value
        rows.append(7 * i % 70 + i // 10)
    return lam, wrench, rows


@slow_uncompiled
@pytest.mark.parametrize("column", range(5))
@pytest.mark.parametrize("mesh", WAYS.values(), ids=WAYS)
def test_spoiled_rows_have_a_status_and_the_others_their_poses(mesh: tuple[int, int], column: int) -> None:
    """Contract: a spoiled row is nan, all others are as without it."""
    model = FiniteElementModel(elements=mesh[0], order=mesh[1])
    exact = model.solve_batch(GOOD, tolerance=1e-13).pose
    lam, wrench, rows = spoiled_rows(column)
    fine = np.setdiff1d(np.arange(70), rows)
    par = np.tile(pack(model.mechanism), (70, 1))
    many = np.concatenate([lam, np.resize(GOOD, (2100, 2))])  # enough that a start is fitted
    for result in (
        model.solve_batch(lam, wrench),
        model.solve_batch(lam, wrench, parameters=par),
        model.solve_batch(many, np.concatenate([wrench, np.zeros((2100, 3))])),
        *([model.solve_batch(many)] if column < 2 else []),
        model.sensitivities(["EI"], lam, wrench),
    ):
        assert result.stable[fine].all()
        assert not result.stable[rows].any()
        numbers_in = np.isfinite(np.hstack([lam, wrench])[rows]).all(axis=1)
        assert ((result.status[rows] == Status.INVALID_INPUT) == ~numbers_in).all()
        # a colossal pull has an equilibrium: the shear beam buckles in tension too
        assert np.isnan(result.pose[rows]).all(axis=1).tolist() == (~result.converged[rows]).tolist()
        np.testing.assert_allclose(result.pose[fine], exact[fine], rtol=0, atol=1e-9)
    np.testing.assert_array_equal(model.solve_batch(GOOD, tolerance=1e-13).pose, exact)


@slow_uncompiled
@pytest.mark.parametrize("mesh", WAYS.values(), ids=WAYS)
def test_after_any_load_the_next_solve_is_the_same_to_the_bit(mesh: tuple[int, int]) -> None:
    """Contract: a solve leaves nothing behind."""
    model = FiniteElementModel(elements=mesh[0], order=mesh[1])
    expected = model.solve((40.0, 10.0))
    for value in [*IMPOSSIBLE, *COLOSSAL]:
        for place in range(5):
            loads = np.array([40.0, 10.0, 0.0, 0.0, 0.0])
            loads[place] = value
            try:
                eq = model.solve(loads[:2], loads[2:])
            except InputError as error:
                one_line(error)
                assert not np.isfinite(value) or (place < 2 and value < 0.0)
            else:
                answered(eq.pose, eq.status)
            again = model.solve((40.0, 10.0))
            assert again.pose.tolist() == expected.pose.tolist()
            assert again.jacobian.tolist() == expected.jacobian.tolist()


@pytest.mark.parametrize("mesh", WAYS.values(), ids=WAYS)
def test_negative_forces_are_refused_by_row_at_every_way_in(mesh: tuple[int, int]) -> None:
    """Contract: the error names the row, at every way in."""
    model, lam = FiniteElementModel(elements=mesh[0], order=mesh[1]), GOOD.copy()
    lam[3, 1] = -2.0
    par = np.tile(pack(model.mechanism), (70, 1))
    for call in (
        lambda: model.solve_batch(lam),
        lambda: model.solve_batch(lam, parameters=par),
        lambda: model.solve_batch(np.concatenate([lam] * 30)),
        lambda: model.sensitivities(["EI"], lam),
    ):
        with pytest.raises(InputError, match=r"^lam_r = -2.0 N in row 3: allowed is >= 0") as caught:
            call()
        one_line(caught.value)
