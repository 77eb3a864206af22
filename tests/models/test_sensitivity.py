"""Derivatives of poses by loads and parameters: central differences, the plain reference, the complex step."""

import numpy as np
import pytest

from ecm_fast import Discretization, FiniteElementModel, InputError, Mechanism, Status
from ecm_fast.kernels.general.sensitivity import pose_sensitivities
from ecm_fast.kernels.layout import N_LOADS
from ecm_fast.mechanism.parameters import PARAMETERS, PLACES, find, index
from ecm_fast.mechanism.vector import pack, unpack
from ecm_fast.models import reference
from ecm_fast.models.loads import loads_of
from ecm_fast.models.sensitivity import _FURTHER as LAWS
from ecm_fast.models.sensitivity import _work

ENDS = ("clamp_rotation", "clamp_axial", "clamp_lateral", "plate_joint")
GIVING_WAY = [index(f"effects.{name}_compliance") for name in ENDS]
"""Effects that let the head move against the tip section, or the first node against the clamp; test_effects has it."""
NAMES = [entry.key for entry in PARAMETERS[: len(PLACES)] if entry.key != "beam.axial_law"]
MESHES = [
    {"order": 5},
    {"order": 3},
    {"elements": 20, "order": 1},
    {"elements": 3, "order": 2},
    {"elements": 2, "gauss": 6},
]
every_mesh = pytest.mark.parametrize("how", MESHES, ids=lambda how: "-".join(f"{k}{v}" for k, v in how.items()) or "1")


def random_necks(n: int, seed: int, *, offset: bool = True, uniform: bool = False) -> np.ndarray:
    """Return parameter vectors (n, n_parameters) about both presets, every effect at its typical size.

    uniform : the stiffnesses are the same along the beam
    """
    rng, rows = np.random.default_rng(seed), []
    for i in range(n):
        par = pack(Mechanism.preset(("slender", "paper")[i % 2]))
        for place, entry in enumerate(PARAMETERS):
            if entry.key.startswith("effects.") and entry.default == 0.0:
                par[place] = max(entry.typical * rng.normal(), entry.lower + 1e-3 * entry.typical)
            elif entry.key not in ("beam.axial_law", "tendons.pulley_x"):
                par[place] *= rng.uniform(0.8, 1.25)
        par[index("axial_law")] = i // 2 % 2
        par[index("tendons.pulley_radius")] = 0.0055 * rng.uniform(0.5, 1.5)
        radius, change = par[index("tendons.pulley_radius")], index("effects.pulley_radius")
        par[change] = max(par[change], 1e-4 - radius)  # no radius is negative
        par[index("b")], par[index("pulley_x")] = 0.01 * rng.normal(), 0.01 * rng.normal()
        par[index("neutral_axis_offset")] *= offset and i % 3 == 0
        par[LAWS] *= not uniform
        rows.append(par)
    return np.array(rows)


def random_loads(n: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.uniform(5.0, 120.0, (n, 2)), rng.normal(size=(n, 3)) * [10.0, 5.0, 0.5]


def sizes(pose: np.ndarray, par: np.ndarray) -> np.ndarray:
    """Return what a coordinate may be compared with, (n, 3): the length, the length, 1 rad."""
    length = par[:, index("length")]
    return np.stack([length, length, np.ones(len(pose))], axis=1)


@every_mesh
def test_derivatives_are_central_differences_of_poses(how):
    """Differences over 1e-4 of a parameter's scale: the cubic term is 1e-8 of it, a pose to 1e-13 counts as 1e-9."""
    n, model = 6, FiniteElementModel(**how)
    par, (lam, wrench) = random_necks(n, seed=1), random_loads(n, seed=2)
    found = model.sensitivities(NAMES, lam, wrench, parameters=par, tolerance=1e-13, path="ignore")
    assert found.stable.all()
    scale = sizes(found.pose, par)

    def difference(change, step):
        above, below = (
            model.solve_batch(
                lam + sign * change.get("lam", 0.0),
                wrench + sign * change.get("wrench", 0.0),
                parameters=par + sign * change.get("par", np.zeros(par.shape[1])),
                tolerance=1e-13,
                path="ignore",
            ).pose
            for sign in (1.0, -1.0)
        )
        return (above - below) / (2.0 * step)

    for k, name in enumerate(NAMES):
        entry = find(name)
        step = 1e-4 * max(abs(entry.default), entry.typical)
        expected = difference({"par": step * np.eye(par.shape[1])[index(name)]}, step)
        assert (np.abs(found.dpose_dpar[:, :, k] - expected) * step / 1e-4 <= 2e-7 * scale).all(), name
    for k in range(2):
        expected = difference({"lam": 0.01 * np.eye(2)[k]}, 0.01)
        assert (np.abs(found.jacobian[:, :, k] - expected) * 100.0 <= 2e-7 * scale).all()
    for k, step in enumerate((0.01, 0.01, 0.001)):
        expected = difference({"wrench": step * np.eye(3)[k]}, step)
        assert (np.abs(found.compliance[:, :, k] - expected) * step * 1e4 <= 2e-7 * scale).all()


@pytest.mark.slow
@pytest.mark.parametrize("how", [{"order": 3}, {"elements": 3, "order": 2}, {"elements": 6, "order": 1}], ids=str)
def test_derivatives_are_those_of_the_reference(how):
    """The plain NumPy reference: dense tangent, and the residual's derivative by the complex step, exact to rounding.

    The tangent's condition, 1e6 here, costs as many digits of 1e-16.
    """
    model = FiniteElementModel(**how)
    mesh: Discretization = model.discretization
    par, (lam, wrench) = random_necks(6, seed=3), random_loads(6, seed=4)
    par[:, GIVING_WAY] = 0.0  # the head is then the tip section, and the first node is held
    found = model.sensitivities(NAMES, lam, wrench, parameters=par, tolerance=1e-13, path="ignore")
    for i in range(len(par)):
        loads = loads_of(lam[i : i + 1], wrench[i : i + 1])[0]
        q = FiniteElementModel(unpack(par[i]), **how).solve(lam[i], wrench[i], path="ignore").raise_if_failed().q
        flexibility = np.linalg.inv(reference.tangent(reference.named(par[i]), mesh, loads, q)[3:, 3:])[-3:]
        np.testing.assert_allclose(found.pose[i], q[-3:], rtol=0, atol=1e-12)
        np.testing.assert_allclose(found.compliance[i], flexibility[:, -3:], rtol=1e-8, atol=1e-12)
        for k, name in enumerate(NAMES):
            if index(name) in GIVING_WAY:
                continue
            p = reference.named(par[i] + 1e-30j * np.eye(par.shape[1])[index(name)])
            moved = q.astype(complex)  # the clamped node goes where the parameter puts it
            moved[:3] = q[:3] + 1j * reference.rest_coordinates(p, mesh)[:3].imag
            change = reference.residual(p, mesh, loads, moved).imag[3:] * 1e30
            expected = -flexibility @ change
            # per 1 % of the parameter's scale, of the length and of 1 rad
            scale = max(abs(find(name).default), find(name).typical) / sizes(found.pose[i : i + 1], par[i : i + 1])[0]
            np.testing.assert_allclose(found.dpose_dpar[i, :, k] * scale, expected * scale, rtol=1e-8, atol=1e-9)
        for side in range(2):
            own, step = reference.named(par[i]), 1e-30j * np.eye(N_LOADS)[side]
            unit = reference.tip_wrench(own, loads + step, q[-3:] + 0j).imag * 1e30
            np.testing.assert_allclose(found.jacobian[i, :, side], flexibility[:, -3:] @ unit, rtol=1e-8, atol=1e-12)


@every_mesh
def test_stiffnesses_written_out_are_the_complex_step(how):
    """The complex step through the same residual, for EA, GA, EI too: virtual work is the same number."""
    model, n = FiniteElementModel(**how), 8
    mesh, par, (lam, wrench) = model.discretization, random_necks(n, seed=5, uniform=True), random_loads(n, seed=6)
    written = model.sensitivities(["EA", "GA", "EI"], lam, wrench, parameters=par, path="ignore")
    q = np.array(
        [
            FiniteElementModel(unpack(own), **how).solve(*case, path="ignore").q
            for own, *case in zip(par, lam, wrench, strict=True)
        ]
    )
    loads, status = np.ones((n, N_LOADS)), np.zeros(n, dtype=np.int64)
    loads[:, :2], loads[:, 2:5] = lam, wrench

    def derivatives(stiffness, which):
        real, complex_ = _work(mesh, len(which))
        out = np.empty((n, 3)), np.empty((n, 3, 2)), np.empty((n, 3, 3)), np.empty((n, 3, 3))
        own = np.zeros(par.shape[1], dtype=complex), *complex_
        constants = mesh.tables, mesh.mesh, mesh.nodes, par
        pose_sensitivities(*constants, stiffness, which, loads, q, status, real, own, *out)
        return out[3]

    none, nowhere = np.full(3, -1), np.empty(0, dtype=np.int64)
    by_virtual_work = derivatives(np.arange(3), nowhere)
    by_complex_step = derivatives(none, np.array([index(name) for name in ("EA", "GA", "EI")]))
    scale = par[:, None, [index(name) for name in ("EA", "GA", "EI")]] / sizes(written.pose, par)[:, :, None]
    np.testing.assert_allclose(by_virtual_work * scale, by_complex_step * scale, rtol=0, atol=1e-12)
    # and these are what a user gets, at the default tolerance
    np.testing.assert_allclose(written.dpose_dpar * scale, by_complex_step * scale, rtol=0, atol=1e-8)


def test_names_may_come_in_any_order():
    """Contract: a derivative does not depend on what else is asked for, to the bit."""
    model, loads = FiniteElementModel(), ([[40.0, 10.0]], [[1.0, 2.0, 0.1]])
    names = ["precurvature", "EI", "beam.length", "GA", "head.h", "EA"]
    together = model.sensitivities(names, *loads)
    assert together.names == tuple(names)
    for k, name in enumerate(names):
        alone = model.sensitivities([name], *loads)
        np.testing.assert_array_equal(alone.dpose_dpar[:, :, 0], together.dpose_dpar[:, :, k])
    none = model.sensitivities([], *loads)
    assert none.dpose_dpar.shape == (1, 3, 0)
    np.testing.assert_array_equal(none.jacobian, together.jacobian)


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["EA", "beam.EA"], "a parameter is named twice in EA, beam.EA"),
        (["axial_law"], "axial_law is a choice, not a number: there is no derivative by it"),
        (["EQ"], "no parameter is called 'EQ'"),
    ],
)
def test_names_that_cannot_be(names, message):
    """Contract: the text of the error."""
    with pytest.raises(InputError, match=f"^{message}"):
        FiniteElementModel().sensitivities(names, [[40.0, 10.0]])


@every_mesh
def test_one_mechanism_for_all_rows_is_one_for_each(how):
    """Contract: two ways to state the same mechanism, to the bit."""
    mechanism = unpack(random_necks(1, seed=7)[0])
    lam, wrench = random_loads(20, seed=8)
    names = ["EA", "clamp_tilt", "EI", "pulley_z"]
    for_all = FiniteElementModel(mechanism, **how).sensitivities(names, lam, wrench, path="ignore")
    for_each = FiniteElementModel(**how).sensitivities(
        names, lam, wrench, parameters=[pack(mechanism)] * 20, path="ignore"
    )
    for name in ("pose", "jacobian", "compliance", "dpose_dpar", "status"):
        np.testing.assert_array_equal(getattr(for_all, name), getattr(for_each, name))


@every_mesh
def test_rows_without_an_equilibrium_are_nan(how):
    """Lost rows are nan; an unstable equilibrium has derivatives, the inverse of an indefinite tangent."""
    model, names = FiniteElementModel(Mechanism().replace(g=0.0), **how), ["EA", "length", "precurvature"]
    lam, wrench = random_loads(6, seed=9)
    clean = model.sensitivities(names, lam, wrench, tolerance=1e-13)
    assert clean.stable.all()
    lam[1], lam[2, 0], wrench[3, 1] = (950.0, 900.0), np.nan, np.inf
    lam[4], wrench[4] = 0.0, (-700.0, 0.0, 0.0)  # the straight column, past its buckling load of 539 N
    found, batch = model.sensitivities(names, lam, wrench, tolerance=1e-13), model.solve_batch(lam, wrench)
    assert found.status.tolist() == batch.status.tolist()
    assert found.status.tolist() == [0, 3, 4, 4, 1, 0]
    arrays = [found.pose, found.jacobian, found.compliance, found.dpose_dpar]
    for array in arrays:
        assert np.isnan(array[[1, 2, 3]]).all()
        assert np.isfinite(array[[0, 4, 5]]).all()
    assert np.linalg.eigvalsh(found.compliance[4])[0] < 0.0
    for own, exact in zip(arrays, [clean.pose, clean.jacobian, clean.compliance, clean.dpose_dpar], strict=True):
        np.testing.assert_array_equal(own[[0, 5]], exact[[0, 5]])
    one = model.solve(lam[4], wrench[4])
    assert one.status is Status.UNSTABLE
    np.testing.assert_allclose(found.compliance[4], one.compliance, rtol=1e-9, atol=1e-12)
    assert repr(found) == "Sensitivities(6 cases by EA, length, precurvature; 2 stable)"


def test_stragglers_are_those_of_the_general_path():
    """Loads so large that the fast path vouches for few: poses and derivatives are those of the single solve."""
    model, rng = FiniteElementModel(order=5), np.random.default_rng(10)
    lam, wrench = rng.uniform(0.0, 700.0, (60, 2)), rng.uniform([-600.0, -150.0, -20.0], [40.0, 150.0, 20.0], (60, 3))
    found = model.sensitivities(["EI"], lam, wrench, tolerance=1e-13)
    for i in range(60):
        eq = model.solve(lam[i], wrench[i])
        assert found.status[i] == eq.status
        np.testing.assert_allclose(found.pose[i], eq.pose, rtol=0, atol=1e-11)
        for own, exact in ((found.jacobian[i], eq.jacobian), (found.compliance[i], eq.compliance)):
            np.testing.assert_allclose(own, exact, rtol=0, atol=1e-7 * np.abs(exact).max())
