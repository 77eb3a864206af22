"""The families of elements beside Lagrange's: their kernels, their accuracy against theory, and what any model can do.

The kernels are checked by the complex step, which is exact to rounding: the residual against the energy of the
reference, the tangent against the residual. Solutions are checked against the tables of `tests/tables`, closed forms,
and each other where theory says that two families are the same.
"""

import itertools

import numpy as np
import pytest

from ecm_fast import FiniteElementModel, InputError, Mechanism, Status
from ecm_fast.kernels import layout, prepare, trig
from ecm_fast.kernels.general.elements import se2, strain
from ecm_fast.mechanism.mesh.discretization import Discretization
from ecm_fast.mechanism.parameters import find
from ecm_fast.mechanism.sections import EFFECT_QUANTITIES
from ecm_fast.mechanism.vector import pack
from ecm_fast.models import reference

KERNELS = {"se2": se2, "strain": strain}
OTHERS = [("se2", 1, None), ("se2", 1, 3), ("strain", 1, None), ("strain", 2, 2), ("strain", 3, None), ("strain", 6, 9)]
LAW = {"nh": "neo-hookean", "hooke": "hooke"}
STIFF = 1e3
LAM, WRENCH = (120.0, 35.0), (-60.0, 25.0, -1.5)


def neck(**changes):
    """Return a neck on finite pulleys whose two sides differ in everything, under gravity."""
    return Mechanism().replace(
        **{"tendons.pulley_radius": 0.0055, "pulley_z": 0.0645, "pulley_x": -0.01, "b": 0.02}
        | {"precurvature": 0.8, "neutral_axis_offset": 2e-3, "pulley_shift": 3e-3, "pulley_height_asymmetry": 4e-3}
        | changes
    )


class Element:
    """One element with every effect of the catalogue, its strains and turn far from those of any equilibrium."""

    def __init__(self, family, order, gauss, seed, turn):
        rng = np.random.default_rng(seed)
        effects = {
            f"effects.{name}": np.clip(3.0 * entry.typical * rng.normal(), entry.lower, entry.upper)
            for name, entry in EFFECT_QUANTITIES.items()
        }
        law = ("neo-hookean", "hooke")[seed % 2]
        par = pack(Mechanism().replace(length=(0.04, 0.4)[seed // 2 % 2], axial_law=law, **effects))
        self.p, self.share, self.loads = reference.named(par), 0.7, np.ones(layout.N_LOADS)
        self.loads[layout.L_GRAVITY] = self.share
        self.h = reference.length(self.p)
        self.family, self.mesh, self.kernels = (
            family,
            Discretization.from_elements(1, order, gauss, family),
            KERNELS[family],
        )
        (self.points,) = reference.stations(self.p, self.mesh)
        self.stations = np.empty((self.mesh.gauss, layout.N_STATION))
        rest = np.empty(3 * self.mesh.nodes.size)
        prepare.prepare(par, self.mesh.mesh, self.mesh.nodes, self.stations, np.empty(layout.N_TIP), rest)
        # about an arc of that turn: stretch and shear of a tenth, inner angles off by as much
        self.q = rest + rng.normal(size=rest.size) * np.tile([0.1 * self.h, 0.1 * self.h, 0.1], order + 1)
        places = self.mesh.local_nodes
        self.q[2::3] += turn * places - (self.q[2::3] - rest[2::3]) * (places * (1.0 - places) == 0.0)
        middle, chord = self.q[2] + 0.5 * turn, self.h * np.sinc(turn / (2.0 * np.pi))
        self.q[-3:-1] = self.q[:2] + chord * np.array([np.cos(middle), -np.sin(middle)]) * [1.1, 0.9]

    def energy(self, q):
        if self.family == "se2":
            weights = np.polynomial.legendre.leggauss(self.mesh.gauss)[1] / 2.0
            return reference.se2_energy(self.points, weights, self.h, q, self.share)
        return reference.strain_energy(self.points, self.mesh.order, self.h, q, self.share)

    def assembled(self):
        """Return residual and the tangent's lower triangle, (m,) and (m, m)."""
        m = self.q.size
        res, K = np.zeros(m), np.zeros((m, m))
        room = np.full(6 * m, np.nan)  # what is left there by others must not matter
        self.kernels.element(self.mesh.tables, self.stations, self.loads, self.q, res, K, room)
        return res, K

    def residual(self, q):
        res = np.zeros(q.size, q.dtype)
        stations = self.stations.astype(q.dtype)
        self.kernels.element_residual(self.mesh.tables, stations, self.loads, q, res)
        return res


TURNS = [0.0, 1e-9, -0.01, 0.4, -0.9999999, 1.0000001, 2.0, -3.3, 5.0]


@pytest.mark.slow
@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize(("family", "order", "gauss"), OTHERS)
def test_kernels_are_derivatives_of_the_reference_energy(family, order, gauss, turn):
    """Complex step: residual by the energy, tangent by the residual, and the tangent symmetric.

    "To rounding" means 1e-13 of the terms: a stiffness times the coordinates for a force.
    """
    for seed in range(4):
        case = Element(family, order, gauss, seed, turn)
        units = np.eye(case.q.size)
        gradient = np.array([case.energy(case.q + 1e-30j * unit).imag * 1e30 for unit in units])
        derivative = np.array([case.residual(case.q + 1e-30j * unit).imag * 1e30 for unit in units]).T
        res, K = case.assembled()
        size = np.abs(derivative) @ np.abs(case.q)
        assert np.abs(res - gradient).max() <= 1e-13 * size.max()
        assert np.abs(case.residual(case.q.astype(complex)).real - res).max() <= 1e-13 * size.max()
        assert np.abs(derivative - derivative.T).max() <= 1e-13 * np.abs(derivative).max()
        assert np.abs(np.tril(K) - np.tril(derivative)).max() <= 1e-13 * np.abs(derivative).max()
        assert np.all(np.triu(K, 1) == 0.0)


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize(("family", "order", "gauss"), OTHERS)
def test_a_step_is_taken_to_first_order(family, order, gauss, turn):
    """Calculus: a step of size t is applied to within t^2 of adding it: a hundredth for a tenth of t."""
    case = Element(family, order, gauss, 1, turn)
    step = np.random.default_rng(2).normal(size=case.q.size) * np.tile([case.h, case.h, 1.0], order + 1)
    left = []
    for size in (1e-3, 1e-4):
        q = case.q.copy()
        case.kernels.apply_step(case.mesh.tables, q, size * step, np.empty(q.size))
        left.append(np.abs(q - case.q - size * step).max())
    assert left[0] < 1e-4
    assert left[1] == pytest.approx(left[0] / 100.0, rel=0.05)


@pytest.mark.parametrize("family", [("se2", 1, None), ("strain", 1, 12), ("strain", 3, 12)])
@pytest.mark.parametrize("law", ["neo-hookean", "hooke"])
def test_constant_curvature_is_exact(table, family, law):
    """Closed form: an end moment bends to a circle, up to two full turns; eight elements hold it to rounding."""
    name, order, gauss = family
    mechanism = Mechanism().replace(g=0.0, axial_law=law)
    model = FiniteElementModel(mechanism, 8, order, gauss, family=name)
    length, EI = mechanism.beam.length, mechanism.beam.EI
    for row in table("pure_bending_circle"):
        eq = model.solve(wrench=(0.0, 0.0, row["ML_over_EI"] * EI / length)).raise_if_failed()
        exact = [row["x_over_L"], -row["abs_z_over_L"], row["ML_over_EI"]]
        assert np.abs(eq.pose / [length, length, 1.0] - exact).max() < 2e-11  # the table's twelve digits
        s, k = np.linspace(0.0, 1.0, 37), row["ML_over_EI"]
        circle = np.stack([np.sin(k * s) / k, (np.cos(k * s) - 1.0) / k, k * s], axis=1)
        # beside rounding, the largest last step of Newton's method, 1e-9, squared once more
        np.testing.assert_allclose(eq.shape(37) / [length, length, 1.0], circle, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize(("elements", "order"), [(1, 1), (5, 1), (1, 3), (3, 2), (2, 4), ([1.0, 3.0], 6)])
def test_with_p_points_the_tip_is_that_of_lagrange_elements(elements, order):
    """Theory: both are Gauss collocation, whose strains at the Gauss points are free and whose poses integrate them."""
    one = FiniteElementModel(neck(), elements, order).solve(LAM, WRENCH).raise_if_failed()
    other = FiniteElementModel(neck(), elements, order, order, family="strain").solve(LAM, WRENCH).raise_if_failed()
    np.testing.assert_allclose(other.q[2::3], one.q[2::3], rtol=0.0, atol=1e-11)
    for mine, theirs in ((other.pose, one.pose), (other.compliance, one.compliance), (other.jacobian, one.jacobian)):
        np.testing.assert_allclose(mine, theirs, rtol=0.0, atol=1e-11 * np.abs(theirs).max())
    np.testing.assert_allclose(other.shape(2), one.shape(2), rtol=0.0, atol=1e-12)


def test_constant_strains_are_the_same_in_both_families():
    """Theory: strain elements of order 1, their poses integrated to rounding, are those of the logarithm of SE(2)."""
    one = FiniteElementModel(neck(), 3, family="se2").solve(LAM, WRENCH).raise_if_failed()
    other = FiniteElementModel(neck(), 3, 1, 12, family="strain").solve(LAM, WRENCH).raise_if_failed()
    np.testing.assert_allclose(other.q, one.q, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(other.compliance, one.compliance, rtol=0.0, atol=1e-11 * one.compliance.max())
    np.testing.assert_allclose(other.shape(23), one.shape(23), rtol=0.0, atol=1e-12)


def inextensible(table, name):
    """Return mechanism, wrench and tip of a table's elastica, see `test_tables`."""
    stiff = {"length": 1.0, "EI": 1.0, "EA": STIFF, "GA": STIFF, "axial_law": "hooke", "g": 0.0}
    if name == "elastica_transverse_tip_load":
        (row,) = [row for row in table(name) if row["alpha"] == 10.0]
        exact = [1.0 - row["u_over_L"], row["w_over_L"] + 10.0 / STIFF, -row["theta_tip_rad"]]
        return Mechanism().replace(**stiff), (0.0, 10.0, 0.0), np.array(exact)
    (row,) = [row for row in table(name) if row["beta"] == 8.0]
    weight = {"g": 1.0, "mass_per_length": 8.0, "head.mass": 0.0, "gravity_tilt": np.pi / 2.0}
    exact = [row["x_over_L"], -row["sag_over_L"] - 8.0 / (2.0 * STIFF), row["slope_tip_rad"]]
    return Mechanism().replace(**stiff | weight), (0.0, 0.0, 0.0), np.array(exact)


@pytest.mark.parametrize("name", ["elastica_transverse_tip_load", "heavy_elastica_horizontal"])
@pytest.mark.parametrize(
    ("family", "order", "coarse"),
    [("lagrange", 1, 16), ("se2", 1, 16), ("strain", 1, 16), ("strain", 2, 16), ("strain", 3, 16), ("strain", 4, 8)],
)
def test_tip_converges_with_the_order_that_the_family_states(table, name, family, order, coarse):
    """Theory, on elasticas under a tip load and under their own weight: the rate of one halving.

    16 elements of order 6 are the solution; they meet the table as far as it goes. By how much 20 of order 5 differ is
    rounding, which the smaller error is known to and no better.
    """
    mechanism, wrench, from_table = inextensible(table, name)
    exact, again = (FiniteElementModel(mechanism, *mesh).solve(wrench=wrench).raise_if_failed().pose
                    for mesh in ((16, 6), (20, 5)))  # fmt: skip
    assert np.abs(exact - from_table).max() < 2e-11
    rounding = np.abs(exact - again).max()
    assert rounding < 1e-13
    errors = []
    for elements in (coarse, 2 * coarse):
        model = FiniteElementModel(mechanism, elements, order, family=family)
        errors.append(np.abs(model.solve(wrench=wrench).raise_if_failed().pose - exact).max())
    assert errors[1] > 2.0 * rounding
    least, most = np.log2(errors[0] / (errors[1] + rounding)), np.log2(errors[0] / (errors[1] - rounding))
    assert least - 0.15 < model.discretization.tip_order < most + 0.15


def test_constant_strains_are_better_than_linear_elements(table):
    """Shooting: both are of second order, but on the slender neck the arcs of SE(2) leave a third of the error."""
    worst = {}
    rows = [row for row in table("tendon_equilibria") if row["L"] == 0.109 and row["routing"] != "pulley"]
    for family, elements in itertools.product(("se2", "lagrange"), (4, 8)):
        errors = []
        for row in rows:
            changes = {"axial_law": LAW[row["law"]], "mass_per_length": row["rhoA"], "head.mass": row["mH"]}
            mechanism = Mechanism.preset("slender").replace(h=row["h"], b=row["b"], **changes)
            model = FiniteElementModel(mechanism, elements, 1, family=family)
            pose = model.solve((row["lambda_l"], row["lambda_r"])).raise_if_failed().pose
            errors.append(pose - [row["x_L"], row["z_L"], row["theta_L_rad"]])
        worst[family, elements] = np.abs(errors).max()
    for elements in (4, 8):
        assert 3.0 * worst["se2", elements] < worst["lagrange", elements]


@pytest.mark.parametrize("stiff", [1e3, 1e5])
@pytest.mark.parametrize(("family", "order", "gauss"), [*OTHERS, ("lagrange", 1, 1), ("lagrange", 1, 2)])
def test_only_linear_elements_with_two_points_lock(family, order, gauss, stiff):
    """Closed form: a locked element is stiffer by the factor 1 + GA h^2 / (12 EI) in bending, see `test_convergence`.

    The slope at a tip is exact for any family that does not lock; the force is so small that the beam is linear.
    """
    mechanism = Mechanism().replace(length=1.0, EI=1.0, EA=stiff, GA=stiff, axial_law="hooke", g=0.0)
    theta = FiniteElementModel(mechanism, 20, order, gauss, family=family).solve(wrench=(0.0, 1e-4, 0.0)).theta
    stiffer = 1.0 + stiff / (12.0 * 20**2) if (family, gauss) == ("lagrange", 2) else 1.0
    assert abs(theta * stiffer / -0.5e-4 - 1.0) < 1e-8


def with_a_shared_tangent(mesh):
    """Coordinates of cubic elements by those of cubic Hermite elements, (3 n_nodes, m), the clamp's pose left out.

    Neighbours share x' and z' at their common node; theta is the cubic Lagrange polynomial of both.
    """
    t, n, size = mesh.local_nodes, mesh.n_elements, mesh.nodes.size
    cubics = np.stack([1 - 3 * t**2 + 2 * t**3, t - 2 * t**2 + t**3, 3 * t**2 - 2 * t**3, t**3 - t**2], axis=1)
    places = np.zeros((size, 2 * n + 2))
    for e in range(n):
        places[3 * e : 3 * e + 4] = 0.0
        places[3 * e : 3 * e + 4, 2 * e : 2 * e + 4] = cubics
    parts = (places[:, 1:], places[:, 1:], np.eye(size)[:, 1:])
    return np.hstack([np.kron(part, unit[:, None]) for part, unit in zip(parts, np.eye(3), strict=True)])


def test_cubic_hermite_elements_gain_nothing():
    """Theory: a shared tangent binds strains at the Gauss points, whose freedom makes Lagrange elements so exact.

    Alone, a Hermite element is the cubic Lagrange element; two or four leave several times the error of as many.
    """
    mechanism = Mechanism.preset("slender")
    p, loads = reference.named(pack(mechanism)), np.array([120.0, 10.0, 0.0, 0.0, 0.0, 1.0])
    exact = FiniteElementModel(mechanism, 8, 6).solve(loads[:2]).raise_if_failed().pose
    for elements in (1, 2, 4):
        model = FiniteElementModel(mechanism, elements, 3)
        mesh, own = model.discretization, model.solve(loads[:2]).raise_if_failed()
        T, q = with_a_shared_tangent(mesh), reference.rest_coordinates(p, mesh)
        for share in (0.5, *[1.0] * 8):
            K, res = (of(p, mesh, share * loads, q) for of in (reference.tangent, reference.residual))
            step = T @ np.linalg.solve(T.T @ K @ T, -T.T @ res)
            q = q + step
        assert np.abs(step).max() < 1e-12
        ratio = np.abs(q[-3:] - exact).max() / np.abs(own.pose - exact).max()
        assert ratio == pytest.approx(1.0, rel=1e-4) if elements == 1 else ratio > 5.0


def critical_load():
    """Dead load at which the slender neck without weight buckles [N]: P (g(P) + P / GA) = pi^2 EI / (4 L^2)."""
    from scipy.optimize import brentq

    def excess(load):
        stretch = brentq(lambda g: 2500.0 * (g - g**-2) + load, 0.3, 1.0, xtol=1e-15)
        return load * (stretch + load / 2420.0) - (np.pi / 0.218) ** 2 * 3.0

    return brentq(excess, 1.0, 700.0, xtol=1e-10)


@pytest.mark.parametrize(
    ("family", "elements", "order", "within"),
    [("se2", 20, 1, 2e-3), ("strain", 20, 1, 2e-3), ("strain", 2, 3, 1e-5), ("strain", 3, 4, 3e-7)],
)
def test_the_verdict_changes_at_the_buckling_load(family, elements, order, within):
    """Closed form, and the Lagrange model: stable below, unstable above, the branch lost at the critical load.

    `within` is what the family's order leaves of (pi h / (2 L))^order.
    """
    critical = critical_load()
    assert critical == pytest.approx(539.05, abs=0.005)
    weightless = Mechanism.preset("slender").replace(g=0.0)
    model = FiniteElementModel(weightless, elements, order, family=family)
    lagrange = FiniteElementModel(weightless, elements=3, order=5)
    for share in (0.5, 1.0 - within, 1.0 + within, 1.3):
        eq = model.solve(wrench=(-share * critical, 0.0, 0.0))
        assert eq.status is (Status.CONVERGED if share < 1.0 else Status.UNSTABLE)
        assert lagrange.solve(wrench=(-share * critical, 0.0, 0.0)).status is eq.status
    assert eq.load_factor * 1.3 == pytest.approx(1.0, abs=within)


@pytest.mark.parametrize("family", [("se2", 4, 1), ("strain", 1, 1), ("strain", 2, 3)])
def test_derivatives_are_central_differences(family):
    """Central differences of fourth order, by loads and by parameters; they leave 1e-9 of a derivative here."""
    name, elements, order = family
    names = ["EA", "GA", "EI", "length", "precurvature", "neutral_axis_offset", "clamp_tilt", "mass_per_length"]
    bed = neck()
    model = FiniteElementModel(bed, elements, order, family=name)
    eq = model.solve(LAM, WRENCH).raise_if_failed()
    got = model.sensitivities(names, [LAM], [WRENCH])
    assert got.stable.all()

    def difference(pose, step):
        return (8.0 * (pose(step) - pose(-step)) - (pose(2.0 * step) - pose(-2.0 * step))) / (12.0 * step)

    values = reference.named(pack(bed))
    for k, parameter in enumerate(names):
        key = find(parameter).key
        step = 1e-3 * values[key] if values[key] else 1e-3

        def pose(change, key=key):
            changed = bed.replace(**{key: values[key] + change})
            return FiniteElementModel(changed, elements, order, family=name).solve(LAM, WRENCH).raise_if_failed().pose

        numeric = difference(pose, step)
        np.testing.assert_allclose(got.dpose_dpar[0, :, k], numeric, rtol=0.0, atol=1e-8 * np.abs(numeric).max())
    for column, step in enumerate((0.5, 0.5, 0.5, 0.5, 0.01)):
        unit = np.eye(5)[column]
        numeric = difference(
            lambda t, unit=unit: model.solve(LAM + t * unit[:2], WRENCH + t * unit[2:]).raise_if_failed().pose, step
        )
        exact = np.hstack([eq.jacobian, eq.compliance])[:, column]
        np.testing.assert_allclose(exact, numeric, rtol=0.0, atol=1e-9 * np.abs(numeric).max())
    np.testing.assert_allclose(got.jacobian[0], eq.jacobian, rtol=0.0, atol=1e-12 * np.abs(eq.jacobian).max())
    np.testing.assert_allclose(got.compliance[0], eq.compliance, rtol=0.0, atol=1e-12 * np.abs(eq.compliance).max())


@pytest.mark.slow
@pytest.mark.parametrize("family", [("se2", 4, 1), ("strain", 2, 3)])
def test_equilibria_are_minima_of_the_reference_energy(family):
    """Complex step and Sylvester: no gradient at the free unknowns, a positive definite second derivative."""
    name, elements, order = family
    model = FiniteElementModel(neck(), elements, order, family=name)
    p, mesh, loads = reference.named(pack(model.mechanism)), model.discretization, np.array([*LAM, *WRENCH, 1.0])
    q = model.solve(LAM, WRENCH).raise_if_failed().q
    assert np.abs(reference.gradient(p, mesh, loads, q)[3:]).max() < 1e-9
    size, scale = q.size - 3, np.tile([1e-5, 1e-5, 1e-4], mesh.nodes.size - 1)
    second = np.empty((size, size))
    for i, unit in enumerate(np.diag(scale)):
        step = np.concatenate([np.zeros(3), unit])
        ahead, behind = (reference.gradient(p, mesh, loads, q + sign * step) for sign in (1.0, -1.0))
        second[i] = (ahead - behind)[3:] * scale / 2.0
    assert np.linalg.eigvalsh(0.5 * (second + second.T)).min() > 0.0


@pytest.mark.parametrize("family", [("se2", 4, 1), ("strain", 2, 3)])
def test_batch_stepper_and_solve_agree(family):
    """Contract: three ways in, one answer; batches to the bit, the stepper to its tolerance."""
    name, elements, order = family
    model = FiniteElementModel(neck(), elements, order, family=name)
    lam = np.array(list(itertools.product((0.0, 60.0, 150.0), repeat=2)))
    alone = np.array([model.solve(case, WRENCH).raise_if_failed().pose for case in lam])
    batch = model.solve_batch(lam, WRENCH)
    assert batch.stable.all()
    np.testing.assert_array_equal(batch.pose, alone)
    by_mechanism = model.solve_batch(lam, WRENCH, parameters=np.repeat(pack(model.mechanism)[None], len(lam), axis=0))
    np.testing.assert_array_equal(by_mechanism.pose, alone)
    step = model.stepper(WRENCH, derivatives=True)
    for case, pose in zip(lam, alone, strict=True):
        *stepped, status = step(*case)
        assert status == Status.CONVERGED
        np.testing.assert_allclose(stepped, pose, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(step.jacobian, model.solve(lam[-1], WRENCH).jacobian, rtol=0.0, atol=1e-12)
    wished = model.inverse(theta=0.05, co_contraction=60.0)
    assert model.solve(wished).theta == pytest.approx(0.05, abs=1e-9)


@pytest.mark.parametrize("family", [("se2", 4, 1), ("strain", 2, 3)])
def test_the_shape_meets_the_nodes_that_are_places(family):
    """Contract: at its own nodes the shape is the solution."""
    name, elements, order = family
    eq = FiniteElementModel(neck(), elements, order, family=name).solve(LAM, WRENCH).raise_if_failed()
    np.testing.assert_allclose(eq.shape(elements + 1), eq.q.reshape(-1, 3)[::order], rtol=0.0, atol=1e-15)


def test_the_arc_is_its_closed_form_on_both_sides_of_its_series():
    """Complex step: v' and v'' are the derivatives of v, and u' = u v; the values meet the logarithm of SE(2)."""
    for phi in (1e-12, 1e-3, 0.5, 0.999999, 1.000001, 3.0, -5.5):
        u, v, dv, ddv = se2._arc(phi)
        s, c = trig.sincos(0.5 * phi)
        assert u == pytest.approx(0.5 * phi / s, rel=1e-15)
        if abs(phi) > 0.1:
            assert v == pytest.approx(1.0 / phi - 0.5 * c / s, rel=1e-12)
        by_u, by_v, by_dv, _ = (part.imag * 1e30 for part in se2._arc(phi + 1e-30j))
        assert (by_u, by_v) == pytest.approx((u * v, dv), rel=1e-13)
        assert by_dv == pytest.approx(ddv, rel=1e-11)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"family": "se3"}, "family = 'se3': allowed is one of 'lagrange', 'se2', 'strain' (did you mean 'se2'?)"),
        ({"family": "Strain"}, "(did you mean 'strain'?)"),
        ({"family": None}, "family = None: allowed is one of"),
        ({"family": "se2", "order": 2}, "order = 2: allowed is a whole number from 1 to 1"),
        ({"family": "strain", "order": 7}, "order = 7: allowed is a whole number from 1 to 6"),
        ({"family": "strain", "order": 3, "gauss": 2}, "gauss = 2: fewer points than the order, 3"),
    ],
)
def test_what_is_refused(changes, message):
    """Contract: the one line of the error."""
    with pytest.raises(InputError) as caught:
        FiniteElementModel(**changes)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_model_says_its_family():
    """Contract: the text, written by hand."""
    assert repr(FiniteElementModel(elements=8, family="se2")) == (
        "FiniteElementModel(8 se2 element(s) of order 1, 1 Gauss points each)"
    )
    assert FiniteElementModel(family="strain").discretization.order == 5
