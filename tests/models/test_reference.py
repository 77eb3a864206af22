"""The kernels against the reference in NumPy, and the reference against its own energy by the complex step.

Each case has every effect of the catalogue at a few times its typical size, elements of unequal lengths, sections
compressed to 0.7 and stretched to 1.4, and a beam bent by up to 3 rad. "To rounding" means 1e-13 of the largest entry:
a hundred additions of terms of that size round by about 1e-14.
"""

from itertools import product

import numpy as np
import pytest

from ecm_fast import Discretization, Mechanism
from ecm_fast.kernels import layout, prepare, trig
from ecm_fast.kernels.camera import read_derivatives
from ecm_fast.kernels.general import front, section, tip
from ecm_fast.kernels.general.elements import lagrange as element_kernel
from ecm_fast.mechanism.catalogue import CATALOGUE
from ecm_fast.mechanism.parameters import PARAMETERS, find, index
from ecm_fast.mechanism.sections import EFFECT_QUANTITIES
from ecm_fast.mechanism.vector import pack
from ecm_fast.models import reference

ROUNDING = 1e-13
LOWER = np.tril_indices(3)
FULL = np.ones(layout.N_LOADS)  # loads of which the section takes the share of what strains the beam alone
"""xx, zx, zz, tx, tz, tt: the order in which the kernels keep a symmetric 3 x 3 matrix."""

CASES = [pytest.param(seed, id=f"seed{seed}-order{1 + seed % 6}-gauss+{seed % 3}") for seed in range(24)]


class Case:
    """A mechanism with every effect, a mesh, loads and a state far from any equilibrium.

    The pulleys are so far below the clamp that no state puts an attachment inside one.
    """

    def __init__(self, seed, reach=1.0):
        rng, effects_rng = np.random.default_rng(seed), np.random.default_rng(seed)
        order = 1 + seed % 6
        self.mesh = Discretization.from_elements(rng.uniform(0.5, 2.0, 1 + seed % 4), order, order + seed % 3)
        effects = {
            f"effects.{name}": np.clip(3.0 * entry.typical * effects_rng.normal(), entry.lower, entry.upper)
            for name, entry in EFFECT_QUANTITIES.items()
        }
        effects["effects.pulley_radius"] = abs(effects["effects.pulley_radius"])  # a radius below zero is none
        self.mechanism = Mechanism().replace(
            length=(0.040, 0.109, 0.4)[seed % 3],
            axial_law=("neo-hookean", "hooke")[seed // 2 % 2],
            pulley_x=-0.7,
            b=0.01 * rng.normal(),
            **{"tendons.pulley_radius": 0.0055 * (seed % 3)},
            **effects,
        )
        self.par = pack(self.mechanism)
        self.p = reference.named(self.par)
        self.loads = np.zeros(layout.N_LOADS)
        self.loads[:7] = [*rng.uniform(0.0, 160.0, 2), *(rng.normal(size=3) * [100.0, 50.0, 5.0]), 0.7, 1.0]
        self.q = reference.rest_coordinates(self.p, self.mesh)
        places = self.mesh.nodes
        theta = self.q[2] + reach * rng.uniform(-3.0, 3.0) * places ** rng.uniform(0.7, 2.0)
        stretch = 1.0 + reach * rng.uniform(-0.3, 0.4, places.size)
        along = stretch * np.array([np.cos(theta), -np.sin(theta)])
        steps = 0.5 * (along[:, 1:] + along[:, :-1]) * np.diff(places) * reference.length(self.p)
        self.q[3::3], self.q[4::3], self.q[2::3] = *np.cumsum(steps, axis=1), theta

    def prepared(self, par=None):
        """Return the kernels' constants, stations, tip and q_rest, of the case or of another parameter vector."""
        par, mesh = self.par if par is None else par, self.mesh
        stations = np.zeros((len(mesh.mesh), layout.N_STATION), par.dtype)
        ends, q_rest = np.zeros(layout.N_TIP, par.dtype), np.empty(3 * mesh.nodes.size, par.dtype)
        prepare.prepare(par, mesh.mesh, mesh.nodes, stations, ends, q_rest)
        return stations, ends, q_rest

    def newton_step(self):
        """Return the kernel's Newton step, the tangent stiffness at the tip and the number of pivots not positive."""
        stations, ends, _ = self.prepared()
        step, K_tip = np.empty(self.q.size), np.empty(6)
        work = np.zeros(front.work_size(self.mesh.n_elements, self.mesh.order))
        count, _ = front.newton_step(self.mesh.basis, stations, ends, self.loads, self.q, work, step, K_tip)
        return step, K_tip, count

    def free_tangent(self):
        """Return the dense tangent of the coordinates that are not held."""
        held = [self.p[f"effects.clamp_{name}_compliance"] == 0.0 for name in ("axial", "lateral", "rotation")]
        free = np.flatnonzero(~np.array([*held, *np.zeros(self.q.size - 3, bool)]))
        return reference.tangent(self.p, self.mesh, self.loads, self.q)[np.ix_(free, free)]

    def elements(self):
        """Yield each element's share of the length, its stations and the place of its coordinates."""
        mesh, width = self.mesh, 3 * self.mesh.order
        for e, share in enumerate(mesh.shares):
            yield share, slice(e * mesh.gauss, (e + 1) * mesh.gauss), slice(e * width, (e + 1) * width + 3)


def assert_close(actual, expected, tolerance=ROUNDING):
    """Assert that the largest difference is below `tolerance` times the largest entry expected."""
    assert np.shape(actual) == np.shape(expected)
    assert np.abs(np.subtract(actual, expected)).max() <= tolerance * np.abs(expected).max()


@pytest.mark.parametrize("seed", CASES)
def test_prepare_is_the_reference_rest_state(seed):
    """Reference: the straight beam in its clamp."""
    case = Case(seed)
    assert_close(case.prepared()[2], reference.rest_coordinates(case.p, case.mesh))


@pytest.mark.parametrize("seed", CASES)
def test_element_is_the_reference_element(seed):
    """Reference [E1], [E2]: force and tangent of every element of the beam."""
    case = Case(seed)
    mesh, weights = case.mesh, np.polynomial.legendre.leggauss(case.mesh.gauss)[1] / 2.0
    stations = case.prepared()[0]
    for points, (share, rows, place) in zip(reference.stations(case.p, mesh), case.elements(), strict=True):
        q, h = case.q[place], share * reference.length(case.p)
        res, K = np.zeros(q.size), np.zeros((q.size, q.size))
        element_kernel.element(mesh.basis, stations[rows], case.loads, q, res, K, np.empty(0))
        force = reference.element_force(points, mesh.basis, weights, h, q, case.loads[layout.L_GRAVITY])
        tangent = reference.element_tangent(points, mesh.basis, weights, h, q)
        assert_close(np.tril(K), np.tril(tangent))
        # forces are what is left of terms of the size of |K| |q|: 1.7e-16 of these was seen
        assert np.abs(res - force).max() <= 1e-15 * (np.abs(tangent) @ np.abs(q)).max()


@pytest.mark.parametrize("seed", CASES)
def test_tip_is_the_reference_tip(seed):
    """Reference [T2], [T3]: wrench, stiffness and the shorter tendon's free length, also with a slack tendon."""
    case = Case(seed)
    ends, pose = case.prepared()[1], case.q[-3:]
    for pulling in ([1, 1], [1, 0], [0, 1], [0, 0]):
        loads = case.loads.copy()
        loads[:2] *= pulling
        wrench, K = np.empty(3), np.empty(6)
        free, angle = tip.tip_wrench(ends, loads, *pose, wrench, K)
        assert_close(wrench, reference.tip_wrench(case.p, loads, pose))
        assert_close(K, reference.tip_stiffness(case.p, loads, pose)[LOWER])
        head = reference.head_pose(case.p, loads, pose)
        assert angle == pytest.approx(head[2], rel=ROUNDING)
        pulled = reference.tendon_forces(case.p, loads) != 0.0
        lengths = [reference.tendon(case.p, side, head)[2] for side, on in zip((-1.0, 1.0), pulled, strict=True) if on]
        assert free == pytest.approx(min(lengths, default=np.inf), rel=ROUNDING)


SECTION = [entry.size.key for entry in CATALOGUE.values() if entry.enters == "section"]


@pytest.mark.parametrize("law", ["neo-hookean", "hooke"])
@pytest.mark.parametrize("present", [[], ["effects.neutral_axis_offset"], *([key] for key in SECTION), SECTION])
def test_section_is_the_reference_section(law, present):
    """Reference [C1] to [C8]: each effect alone and all together, from 0.3 to 3, bent to either side."""
    sizes = {key: 2.0 * find(key).typical for key in present}
    mesh = Discretization.from_elements(1, 1)
    case = prepared(Mechanism().replace(axial_law=law, **sizes), mesh)
    p = reference.station(reference.named(case[0]), mesh.mesh[0, 0], 0.0, 1.0, 0, 1)
    hooke = float(law == "hooke")
    for gamma_x, kappa in product((0.3, 0.7, 0.9999, 1.0, 1.0001, 1.4, 3.0), (-15.0, -0.3, 0.3, 15.0)):
        # N is a difference of terms of the size of EA, so that is what rounds
        assert_close(section.axial_law(p["beam.EA"], hooke, gamma_x), reference.axial_law(p, gamma_x))
        strains = np.array([gamma_x, -0.3, kappa])
        N, Q, M, N_x, N_z, N_k, Q_z, Q_k, M_k = section.section_law(case[1][0], FULL, *strains)
        assert_close(np.array([N, Q, M]), reference.section_law(p, strains))
        stiffness = np.array([[N_x, N_z, N_k], [N_z, Q_z, Q_k], [N_k, Q_k, M_k]])
        assert_close(stiffness, reference.section_stiffness(p, strains))
        energy = [reference.section_energy(p, strains + 1e-30j * unit).imag * 1e30 for unit in np.eye(3)]
        assert_close(np.array(energy), reference.section_law(p, strains))


def prepared(mechanism, mesh):
    """Return a mechanism's vector, and the kernels' constants: stations, tip, q_rest."""
    par = pack(mechanism)
    stations, ends = np.empty((len(mesh.mesh), layout.N_STATION)), np.empty(layout.N_TIP)
    prepare.prepare(par, mesh.mesh, mesh.nodes, stations, ends, np.empty(3 * mesh.nodes.size))
    return par, stations, ends


def test_camera_is_the_reference_camera():
    """Reference [V1]: readings, and their derivatives by pose and parameters, which are the complex step's."""
    camera_keys = [entry.key for effect in CATALOGUE.values() if effect.enters == "camera" for entry in effect]
    par = pack(Mechanism().replace(**{key: 3.0 * find(key).typical for key in camera_keys}))
    poses = np.random.default_rng(5).uniform(-1.0, 1.0, (20, 3)) * [0.1, 0.1, 1.5]
    which = np.array([index(key) for key in camera_keys])
    seen, jacobian, compliance = poses.copy(), np.ones((20, 3, 2)), np.tile(np.eye(3), (20, 1, 1))
    by = np.zeros((20, 3, which.size))
    read_derivatives(
        par[None], which, np.arange(which.size), np.zeros(par.size, complex), np.empty((3, 3)), seen, jacobian,
        compliance, by,
    )  # fmt: skip
    for i, pose in enumerate(poses):
        assert_close(seen[i], reference.reading(reference.named(par), pose))
        units = [reference.reading(reference.named(par), pose + 1e-30j * unit).imag * 1e30 for unit in np.eye(3)]
        assert_close(compliance[i], np.array(units).T)
        assert_close(jacobian[i], np.array(units).sum(axis=0)[:, None] * np.ones(2))
        steps = [reference.reading(reference.named(par + 1e-30j * np.eye(par.size)[k]), pose) for k in which]
        assert_close(by[i], np.array([step.imag * 1e30 for step in steps]).T)


def test_sincos_is_numpys():
    """NumPy: sine and cosine to 2e-16 for |t| < 1e5 plus NumPy's own rounding; next to multiples of pi/4 too."""
    near = np.arange(-64, 65) * np.pi / 4.0
    angles = [np.linspace(-30.0, 30.0, 20_001), np.linspace(-1e5, 1e5, 20_001), near, np.nextafter(near, 100.0)]
    angles = np.concatenate([*angles, np.nextafter(near, -100.0)])
    ours = np.array([trig.sincos(angle) for angle in angles])
    assert np.abs(ours - np.stack([np.sin(angles), np.cos(angles)], axis=1)).max() < 2e-16 + 1.2e-16
    assert trig.sincos(0.0) == (0.0, 1.0)


def test_sincos_passes_the_complex_step():
    """Calculus: the derivative of (sin, cos) is (cos, -sin), in every quadrant.

    The series of the sine ends with t^15, so that its derivative lacks t^16/16!, 1.0e-15 at pi/4; the rest is rounding.
    """
    for angle in np.linspace(-7.0, 7.0, 29):
        sine, cosine = trig.sincos(angle + 1e-30j)
        assert abs(sine.imag * 1e30 - np.cos(angle)) < 1.4e-15
        assert abs(cosine.imag * 1e30 + np.sin(angle)) < 1.4e-15


def test_parameters_pass_prepare_as_complex_numbers():
    """Central differences: the complex step differentiates every constant by every parameter.

    A step of 1e-5 of the parameter makes half the difference err by 1e-15 / 6 of the constant, beside rounding.
    """
    case = Case(1)
    for place, entry in enumerate(PARAMETERS):
        if entry.key != "beam.axial_law":
            unit = np.eye(case.par.size)[place]
            step = 1e-5 * case.par[place]
            higher, lower = case.prepared(case.par + step * unit), case.prepared(case.par - step * unit)
            for above, below, constants in zip(higher, lower, case.prepared(case.par + 1e-30j * unit), strict=True):
                difference = 0.5 * (above - below)
                assert (np.abs(difference - step * 1e30 * constants.imag) <= 1e-14 * np.abs(constants.real)).all()


@pytest.mark.parametrize("seed", CASES)
def test_newton_step_is_the_reference_step(seed):
    """Reference [A1]: the step by a dense solve, and the tip stiffness by dense condensation.

    Both lose digits to the condition of the tangent, 2e3 to 2e7 here (m and rad are mixed, and a clamp that gives way
    by micrometers is a stiff spring). The tolerance is that many times the unit roundoff, 1e-16, which is the least a
    stable solve can be held to.
    """
    case = Case(seed, reach=0.1)
    step, K_tip, _ = case.newton_step()
    dense = case.free_tangent()
    tolerance = 1e-16 * np.linalg.cond(dense)
    assert tolerance < 2e-9
    assert_close(step, reference.newton_step(case.p, case.mesh, case.loads, case.q), tolerance)
    assert_close(K_tip, np.linalg.inv(np.linalg.inv(dense)[-3:, -3:])[LOWER], tolerance)


@pytest.mark.slow
def test_pivots_count_negative_eigenvalues():
    """Sylvester's law of inertia: as many pivots are not positive as the dense tangent has negative eigenvalues."""
    counts = []
    for seed in range(150):
        case = Case(seed, reach=(0.1, 0.3, 1.0)[seed % 3])
        _, _, count = case.newton_step()
        eigenvalues = np.linalg.eigvalsh(case.free_tangent())
        assert count == np.sum(eigenvalues < 0.0)
        counts.append(count)
    assert {0, 1, 2} <= set(counts)


@pytest.mark.slow
@pytest.mark.parametrize("seed", CASES)
def test_reference_tangent_is_the_derivative_of_the_residual(seed):
    """Complex step, exact to rounding: the tangent is d(residual)/dq and symmetric, as all forces have an energy."""
    case = Case(seed)
    K = reference.tangent(case.p, case.mesh, case.loads, case.q)
    columns = [
        reference.residual(case.p, case.mesh, case.loads, case.q + 1e-30j * unit).imag * 1e30
        for unit in np.eye(case.q.size)
    ]
    assert_close(np.stack(columns, axis=1), K, 1e-12)
    assert np.abs(K - K.T).max() < ROUNDING * np.abs(K).max()


@pytest.mark.slow
@pytest.mark.parametrize("seed", CASES)
def test_reference_residual_is_the_gradient_of_the_energy(seed):
    """Complex step, exact to rounding: every force, also a tendon's on its pulley, is minus the energy's gradient."""
    case = Case(seed)
    gradient = [
        reference.energy(case.p, case.mesh, case.loads, case.q + 1e-30j * unit).imag * 1e30
        for unit in np.eye(case.q.size)
    ]
    assert_close(np.array(gradient), reference.residual(case.p, case.mesh, case.loads, case.q), 1e-12)
    # the tip's wrench is small beside the beam's forces here, so it is held to its own size
    pose = case.q[-3:]
    wrench = [-reference.tip_energy(case.p, case.loads, pose + 1e-30j * unit).imag * 1e30 for unit in np.eye(3)]
    assert_close(np.array(wrench), reference.tip_wrench(case.p, case.loads, pose), 1e-13)
