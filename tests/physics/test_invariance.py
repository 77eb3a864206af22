"""Invariance: frame, side, units, step of a derivative, position along the beam."""

import numpy as np
import pytest

from ecm_fast import CATALOGUE, FiniteElementModel, Mechanism
from ecm_fast.mechanism.parameters import PARAMETERS, find
from ecm_fast.mechanism.vector import pack
from ecm_fast.models import reference

LAM, WRENCH = (120.0, 35.0), (-60.0, 25.0, -1.5)


def neck(**changes):
    """Return a neck on finite pulleys whose two sides differ in everything, under gravity."""
    return Mechanism().replace(
        **{"tendons.pulley_radius": 0.0055, "pulley_z": 0.0645, "pulley_x": -0.01, "b": 0.02}
        | {"precurvature": 0.8, "neutral_axis_offset": 2e-3, "pulley_shift": 3e-3, "pulley_height_asymmetry": 4e-3}
        | changes
    )


def turn(angle):
    """Return the matrix that turns a wrench or a displacement (x, z, theta) by `angle` about e_y."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize("angle", [1e-3, -0.4, 1.0, np.pi / 2.0, np.pi, -2.5])
@pytest.mark.parametrize("family", [("lagrange", 2, 5), ("se2", 3, 1), ("strain", 2, 1), ("strain", 2, 4)])
def test_the_whole_test_bed_turned(family, angle):
    """Frame indifference: clamp, gravity, pulleys and wrench turned together turn the solution, and nothing else.

    Positive angles turn e_x to (cos a, -sin a), but gravity_tilt turns -e_x the other way.
    """
    (name, elements, order), straight = family, neck()
    beds, effects = straight.tendons, straight.effects
    left = [beds.pulley_x + effects["pulley_height_asymmetry"] / 2.0, beds.pulley_z + effects["pulley_shift"], 0.0]
    right = [beds.pulley_x - effects["pulley_height_asymmetry"] / 2.0, -beds.pulley_z + effects["pulley_shift"], 0.0]
    (l_x, l_z, _), (r_x, r_z, _) = turn(angle) @ left, turn(angle) @ right
    turned = straight.replace(
        clamp_tilt=angle,
        gravity_tilt=-angle,
        pulley_height=(l_x + r_x) / 2.0 - beds.pulley_x,
        pulley_height_asymmetry=l_x - r_x,
        pulley_spacing=(l_z - r_z) / 2.0 - beds.pulley_z,
        pulley_shift=(l_z + r_z) / 2.0,
    )
    one = FiniteElementModel(straight, elements, order, family=name).solve(LAM, WRENCH).raise_if_failed()
    other = FiniteElementModel(turned, elements, order, family=name).solve(LAM, turn(angle) @ WRENCH).raise_if_failed()
    shape = one.shape(9) @ turn(angle).T + [0.0, 0.0, angle]
    # coordinates of 0.1 m and loads of 200 N, rounded to 1e-16 of themselves, on a compliance of 1e-2 rad/N
    np.testing.assert_allclose(other.shape(9), shape, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(
        other.compliance, turn(angle) @ one.compliance @ turn(angle).T, rtol=0.0, atol=1e-11 * one.compliance.max()
    )
    np.testing.assert_allclose(other.jacobian, turn(angle) @ one.jacobian, rtol=0.0, atol=1e-11 * one.jacobian.max())


@pytest.mark.parametrize("law", ["neo-hookean", "hooke"])
def test_left_and_right_exchanged(law):
    """Mirror symmetry: tendons exchanged and everything odd reversed keeps x and reverses z and theta.

    What is odd among the effects is what the catalogue says. Only the order of a few sums differs.
    """
    known = [effect for effect in CATALOGUE.values() if effect.mirror != "path"]
    sizes = {effect.size.key: 2.0 * effect.size.typical for effect in known}
    mechanism = Mechanism().replace(axial_law=law, b=0.01, **sizes)
    mirrored = {effect.size.key: -sizes[effect.size.key] for effect in known if effect.mirror == "odd"}
    one = FiniteElementModel(mechanism).solve(LAM, WRENCH).raise_if_failed()
    other = FiniteElementModel(mechanism.replace(b=-0.01, **mirrored)).solve(LAM[::-1], WRENCH * np.array([1, -1, -1]))
    assert abs(one.z) > 1e-3
    np.testing.assert_allclose(other.pose, one.pose * [1, -1, -1], rtol=0.0, atol=1e-14)


@pytest.mark.parametrize(("scale", "tolerance"), [(4.0, 0.0), (0.125, 0.0), (3.7, 1e-13)])
def test_every_length_scaled(scale, tolerance):
    """Dimensional analysis: lengths times s and EI times s^2 at the same forces scale the pose; powers of 2 exactly."""
    one = neck()
    names = ["length", "h", "b", "plate_half_width", "pulley_x", "pulley_z", "tendons.pulley_radius"]
    names += ["neutral_axis_offset", "pulley_shift", "pulley_height_asymmetry", "soft_spot.width"]
    changes = {name: scale * _value(one, name) for name in names}
    changes["EI"] = scale**2 * one.beam.EI
    changes["mass_per_length"] = one.beam.mass_per_length / scale
    changes["precurvature"] = one.effects["precurvature"] / scale
    pose = FiniteElementModel(one).solve(LAM, WRENCH).raise_if_failed().pose
    wrench = (*WRENCH[:2], scale * WRENCH[2])
    scaled = FiniteElementModel(one.replace(**changes)).solve(LAM, wrench).raise_if_failed().pose
    np.testing.assert_allclose(scaled / [scale, scale, 1.0], pose, rtol=tolerance, atol=0.0)


@pytest.mark.parametrize(("scale", "tolerance"), [(4.0, 0.0), (0.125, 0.0), (3.7, 1e-13)])
def test_every_force_scaled(scale, tolerance):
    """Dimensional analysis: stiffnesses, masses and loads times s leave the pose alone; powers of 2 exactly."""
    one = neck()
    names = ["EA", "GA", "EI", "mass_per_length", "head.mass"]
    pose = FiniteElementModel(one).solve(LAM, WRENCH).raise_if_failed().pose
    other = FiniteElementModel(one.replace(**{name: scale * _value(one, name) for name in names}))
    scaled = other.solve(scale * np.array(LAM), scale * np.array(WRENCH)).raise_if_failed().pose
    np.testing.assert_allclose(scaled, pose, rtol=tolerance, atol=0.0)


def _value(mechanism, name):
    return reference.named(pack(mechanism))[find(name).key]


@pytest.mark.parametrize("name", CATALOGUE)
def test_an_effect_of_zero_is_no_effect(name):
    """The baseline, bit for bit, at size zero, in a batch too; and a pose that moves at twice the typical size.

    What the camera does and what depends on the rows before does not move the neck; `test_effects` has their readings.
    """
    baseline = FiniteElementModel(Mechanism()).solve(LAM, WRENCH).pose
    size = CATALOGUE[name].size
    absent = FiniteElementModel(Mechanism().replace(**{size.key: 0.0})).solve(LAM, WRENCH).pose
    assert absent.tolist() == baseline.tolist()
    par = np.stack([pack(Mechanism())] * 2)
    par[1, PARAMETERS.index(size)] = -0.0
    batch = FiniteElementModel().solve_batch([LAM] * 2, [WRENCH] * 2, parameters=par)
    assert batch.pose[1].tolist() == batch.pose[0].tolist()
    touching = {entry.key: 0.2 for entry in CATALOGUE[name] if entry.key.endswith(".angle")}
    mechanism = Mechanism().replace(**{size.key: 2.0 * size.typical, **touching})
    bent = (20.0, 120.0), (0.0, -40.0, 2.0)  # to positive angles, beyond the stops
    there, here = (FiniteElementModel(neck).solve(*bent, path="ignore").pose for neck in (mechanism, Mechanism()))
    moved = np.abs(there - here).max()
    assert moved == 0.0 if CATALOGUE[name].enters in ("camera", "path") else moved > 1e-7


@pytest.fixture(scope="module", params=[(1, 6), (3, 2)], ids=["1x6", "3x2"])
def solved(request):
    """Return a model and an equilibrium of the lopsided neck."""
    model = FiniteElementModel(neck(), *request.param)
    return model, model.solve(LAM, WRENCH).raise_if_failed()


def test_derivatives_are_central_differences(solved):
    """Central differences of fourth order: steps of 0.5 N and 10 mN m leave 1e-11 of a derivative, as rounding does."""
    model, eq = solved
    steps = np.array([0.5, 0.5, 0.5, 0.5, 0.01])

    def pose(shift):
        return model.solve(LAM + shift[:2], WRENCH + shift[2:]).raise_if_failed().pose

    differences = [8.0 * (pose(u) - pose(-u)) - (pose(2.0 * u) - pose(-2.0 * u)) for u in np.diag(steps)]
    numeric = np.transpose(differences) / (12.0 * steps)
    np.testing.assert_allclose(np.hstack([eq.jacobian, eq.compliance]), numeric, rtol=1e-10, atol=0.0)


def test_derivatives_are_those_of_the_reference(solved):
    """Implicit function theorem: K dq = d(loads), K the complex step of the reference's residual, solved densely."""
    model, eq = solved
    p, mesh, q = reference.named(pack(model.mechanism)), model.discretization, eq.q
    loads = np.array([*LAM, *WRENCH, 1.0])
    K = np.stack([reference.residual(p, mesh, loads, q + 1e-30j * e).imag * 1e30 for e in np.eye(q.size)], axis=1)
    pulls = [reference.tip_wrench(p, unit, q[-3:]) for unit in np.eye(6)[:5]]
    right = np.zeros((q.size - 3, 5))
    right[-3:] = np.transpose(pulls)
    exact = np.linalg.solve(K[3:, 3:], right)[-3:]
    # the unit roundoff, 1e-16, times a tenth of the condition of K, 4e5
    np.testing.assert_allclose(np.hstack([eq.jacobian, eq.compliance]), exact, rtol=1e-11, atol=0.0)


def test_compliance_is_symmetric(solved):
    """Maxwell & Betti: every force has an energy."""
    _, eq = solved
    np.testing.assert_allclose(eq.compliance, eq.compliance.T, rtol=1e-15, atol=0.0)
    assert np.linalg.eigvalsh(eq.compliance).min() > 0.0


def test_shape_meets_the_nodes():
    """Interpolation: linear elements of equal length have their nodes at even places."""
    eq = FiniteElementModel(Mechanism(), elements=20, order=1).solve(LAM, WRENCH)
    np.testing.assert_allclose(eq.shape(21), eq.q.reshape(-1, 3), rtol=0.0, atol=1e-16)


@pytest.mark.parametrize("elements", [1, 4, [1.0, 2.0, 0.5]])
def test_shape_of_a_pure_moment_is_the_circle(elements):
    """Closed form: x = sin(k s)/k, z = -(1 - cos(k s))/k, theta = k s at every place, tip included.

    Between its nodes, one element of order 6 can follow x(s) to 0.8^6 / (2^7 7!) times the largest value of its node
    polynomial, 0.024: that is 1.0e-8 of the length.
    """
    model = FiniteElementModel(Mechanism().replace(g=0.0), elements, order=6)
    length, EI = model.mechanism.beam.length, model.mechanism.beam.EI
    moment = 0.8 * EI / length
    eq = model.solve(wrench=(0.0, 0.0, moment)).raise_if_failed()
    s, k = np.linspace(0.0, length, 37), moment / EI
    circle = np.stack([np.sin(k * s) / k, (np.cos(k * s) - 1.0) / k, k * s], axis=1)
    np.testing.assert_allclose(eq.shape(37), circle, rtol=0.0, atol=1.0e-8 * length)
    np.testing.assert_allclose(eq.shape(2), [[0.0, 0.0, 0.0], eq.pose], rtol=0.0, atol=5e-16)
