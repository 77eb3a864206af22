"""The effects of the catalogue on the test bed: their laws against energies, closed forms, symmetries, and hand counts.

None of this uses the model that is tested on the test bed.
"""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy import integrate

from ecm_fast import Mechanism
from ecm_fast.data.measurements import Measurements
from ecm_fast.errors import InputError
from ecm_fast.mechanism.catalogue import CATALOGUE
from ecm_fast.testbed import OUTSIDE, Sensors, equilibria, history, laws, measure, section, strong_form

WEIGHTLESS = Mechanism().replace(g=0.0)
L, EA, GA, EI = 0.109, 7500.0, 2420.0, 3.0
SIZES = {effect.name: effect.size for effect in CATALOGUE.values()}
STATIC = [effect for effect in CATALOGUE.values() if effect.enters != "path"]
CAMERA = np.array([1e-4, 1e-4, 1e-3])
"""Noise of x, z, theta [m, m, rad]."""
CORNERED = ("bimodulus", "contact_stop", "contact_stop_one_sided")
"""Laws whose second derivative jumps: differences of poses carry less digits."""


def rows(**columns):
    return Measurements.from_columns(columns)


def campaign(swapped=False):
    """Return sixteen loads, up to the full one on either side, with times and in an order that goes up and down."""
    rng = np.random.default_rng(8)
    lam = np.vstack([rng.uniform(0.0, 160.0, (12, 2)), [[160.0, 0.0], [0.0, 160.0], [160.0, 160.0], [0.0, 0.0]]])
    lam = lam[:, ::-1] if swapped else lam
    dwell = rng.uniform(5.0, 120.0, 16)
    return rows(lam_l_N=lam[:, 0], lam_r_N=lam[:, 1], t_s=np.cumsum(dwell + 5.0), dwell_s=dwell)


def sized(name, size):
    return Mechanism().replace(**{SIZES[name].key: size})


def seen(mechanism, loads, **hidden):
    return measure(mechanism, loads, Sensors.perfect(), hidden=hidden).pose


def poses(mechanism, **columns):
    return seen(mechanism, rows(**columns))


# --- every effect


@pytest.fixture
def quick(monkeypatch):
    """Integrate to less digits, where two integrations that are compared err alike."""
    monkeypatch.setattr(strong_form, "_TOLERANCE", 1e-9)


@pytest.fixture(scope="module")
def plain():
    return seen(Mechanism(), campaign())


@pytest.fixture(scope="module")
def quickly():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(strong_form, "_TOLERANCE", 1e-9)
        return seen(Mechanism(), campaign())


HARDLY = {"shear_cubic": 0.005}
"""Largest shift in sigmas of the camera at the typical size of what these loads hardly show."""


@pytest.mark.slow
@pytest.mark.parametrize("name", CATALOGUE)
def test_every_effect_is_felt_and_its_size_has_a_slope_at_zero(name, quick, quickly):
    """Calculus: the change at twice a small size is twice the change, and not zero."""
    h = SIZES[name].typical / 64.0
    up, twice = ((seen(sized(name, size), campaign()) - quickly) / CAMERA for size in (h, 2.0 * h))
    assert np.abs(64.0 * up).max() > HARDLY.get(name, 0.05)
    assert np.abs(twice - 2.0 * up).max() < 0.05 * np.abs(twice).max()


@pytest.mark.slow
@pytest.mark.parametrize("effect", [e for e in STATIC if e.mirror != "mixed"], ids=lambda e: e.name)
def test_exchanging_left_and_right_mirrors_the_pose(effect, quick):
    """Mirror symmetry: tendons exchanged, odd effects reversed."""
    size = effect.size.typical
    one = seen(sized(effect.name, size), campaign())
    other = seen(sized(effect.name, -size if effect.mirror == "odd" else size), campaign(swapped=True))
    np.testing.assert_allclose(other, one * [1.0, -1.0, -1.0], rtol=0, atol=1e-6 if effect.name in CORNERED else 1e-11)


def test_a_stop_on_one_side_is_half_the_stop_on_both():
    """Geometry: on the touched side one stop is both, elsewhere it is none."""
    one, both = (seen(sized(name, 5.0), campaign()) for name in ("contact_stop_one_sided", "contact_stop"))
    touched = both[:, 2] > 0.4 - 1e-9
    assert touched.any()
    np.testing.assert_allclose(one[touched], both[touched], rtol=0, atol=1e-10)
    np.testing.assert_allclose(one[~touched & (both[:, 2] > 0.0)], both[~touched & (both[:, 2] > 0.0)], atol=1e-10)


@pytest.mark.parametrize("name", OUTSIDE)
def test_every_effect_outside_the_catalogue_is_felt(name, plain):
    """Contract: 0 is absent to the bit, the typical size is above the camera's noise."""
    loads = campaign()
    np.testing.assert_array_equal(seen(Mechanism(), loads, **{name: 0.0}), plain)
    shift = np.abs(seen(Mechanism(), loads, **{name: OUTSIDE[name].typical}) - plain) / CAMERA
    assert shift.max() > 5.0  # sigma of the camera


def test_effects_outside_the_catalogue_are_no_parameters():
    """Contract: the text of the error."""
    assert not set(OUTSIDE) & set(CATALOGUE)
    with pytest.raises(InputError, match=r"^gide_friction: no effect of the test bed is called so \(did you mean "):
        seen(Mechanism(), campaign(), gide_friction=1.0)
    with pytest.raises(InputError, match=r"^slack = nan: allowed is a finite number$"):
        seen(Mechanism(), campaign(), slack=math.nan)


# --- the section: gradients of the declared energies


def h_of_section():
    return math.sqrt(12.0 * EI / EA)


def bimodulus(g, u, a):
    """Integrate the extra energy over the fibers, by quadrature up to where they are stretched."""
    half = 0.5 * h_of_section()
    ends = [-half, half] if u == 0.0 else sorted({-half, half, float(np.clip((1.0 - g) / u, -half, half))})
    parts = [
        integrate.quad(lambda zeta: max(g - 1.0 + zeta * u, 0.0) ** 2, *pair, epsabs=1e-15)[0]
        for pair in pairwise(ends)
    ]
    return a * EA / (2.0 * h_of_section()) * sum(parts)


def axial_energy(g):
    return EA / 3.0 * (g**2 / 2.0 + 1.0 / g - 1.5)


def mooney_rivlin(g, a):
    return integrate.quad(lambda s: a * EA / 3.0 * (s - s**-2) * (1.0 / s - 1.0), 1.0, g, epsabs=1e-15)[0]


def ogden(g, a):
    m = 2.0 + a
    energy = 2.0 * EA / (3.0 * m) * ((g**m - 1.0) / m + 2.0 / m * (g ** (-m / 2.0) - 1.0))
    return energy - axial_energy(g)


ENERGIES = {
    "precurvature": lambda g, q, u, a: EI / 2.0 * ((u - a) ** 2 - u**2),
    "bending_cubic": lambda g, q, u, a: a * EI * u**4 / 4.0,
    "bending_amplitude": lambda g, q, u, a: a * EI * abs(u) ** 3 / 3.0,
    "bending_one_sided": lambda g, q, u, a: a * EI * u**3 / 3.0,
    "bimodulus": lambda g, q, u, a: bimodulus(g, u, a),
    "neo_hookean_section": lambda g, q, u, a: a * EI * u**2 / 2.0 * ((1.0 + 2.0 / g**3) / 3.0 - 1.0),
    "mooney_rivlin": lambda g, q, u, a: mooney_rivlin(g, a),
    "ogden": lambda g, q, u, a: ogden(g, a),
    "shear_cubic": lambda g, q, u, a: a * GA * q**4 / 4.0,
    "shear_compression": lambda g, q, u, a: a * EA / 3.0 * (g - g**-2) * q**2 / 2.0,
}


@pytest.mark.parametrize("offset", [0.0, 2e-3])
@pytest.mark.parametrize("name", ENERGIES)
def test_a_law_of_the_section_does_the_work_that_its_energy_says(name, offset):
    """Energy: force and couple are the complex-step gradient of an energy written here."""
    a = SIZES[name].typical
    p = laws.named(Mechanism().replace(**{name: a, "neutral_axis_offset": offset}))

    def energy(g_x, q, k):
        g = g_x + offset * k
        return axial_energy(g) + GA * q**2 / 2.0 + EI * k**2 / 2.0 + ENERGIES[name](g, q, k, a)

    rng = np.random.default_rng(4)
    for _ in range(4):
        start, end = rng.uniform([0.9, -0.05, -5.0], [1.05, 0.05, 5.0], (2, 3))

        def power(t, start=start, end=end):
            strains = (start + t * (end - start))[:, None]
            return float(section.section(p, 0.03, strains)[:, 0] @ (end - start))

        work = integrate.quad(power, 0.0, 1.0, epsabs=1e-11, epsrel=1e-11, limit=400)[0]
        assert work == pytest.approx(energy(*end) - energy(*start), rel=1e-8, abs=1e-9)


@pytest.mark.parametrize("name", [*section.FURTHER, "effects.neutral_axis_offset", "none"])
def test_the_tangent_of_the_section_is_symmetric(name):
    """Energy: second derivatives commute."""
    size = {} if name == "none" else {name: 2.0 * SIZES[name.partition(".")[2]].typical}
    p = laws.named(Mechanism().replace(**{"neutral_axis_offset": 2e-3, **size}))
    strains = np.random.default_rng(1).uniform([[0.9], [-0.05], [-5.0]], [[1.05], [0.05], [5.0]], (3, 200))
    tangent = strong_form.differentiated(lambda at: section.section(p, 0.05, at), strains)[1]
    np.testing.assert_allclose(tangent, tangent.swapaxes(0, 1), rtol=1e-12, atol=1e-9)


def test_stretched_fibers_count_where_the_section_is_straight():
    """Without curvature all fibers stretch alike; with it alone, half of them do."""
    p = laws.named(Mechanism().replace(bimodulus=0.1))
    base = laws.named(Mechanism())
    strains = np.array([[1.05, 0.95, 1.0, 1.0], [0.0] * 4, [0.0, 0.0, 3.0, -3.0]])
    more = section.section(p, 0.0, strains) - section.section(base, 0.0, strains)
    np.testing.assert_allclose(more[0, :2], [0.1 * EA * 0.05, 0.0], rtol=1e-12)
    np.testing.assert_allclose(more[2], [0.0, 0.0, 0.05 * EI * 3.0, -0.05 * EI * 3.0], rtol=1e-12, atol=1e-14)


# --- closed forms of the beam


@pytest.mark.parametrize("tau", [4.0, -9.0])
def test_bending_laws_under_a_couple_are_circles(tau):
    """Closed form: a couple bends to a circle whose curvature the law gives."""
    for name, a, law in (
        ("bending_cubic", 0.008, lambda k: k * (1.0 + 0.008 * k * k)),
        ("bending_amplitude", 0.028, lambda k: k * (1.0 + 0.028 * abs(k))),
        ("bending_one_sided", 0.028, lambda k: k * (1.0 + 0.028 * k)),
        ("bimodulus", 0.2, lambda k: 1.1 * k),  # if the centerline kept its length; see below
    ):
        (pose,) = poses(WEIGHTLESS.replace(**{name: a}), tau_Nm=[tau])
        k = pose[2] / L
        if name == "bimodulus":
            assert EI * law(k) == pytest.approx(tau, rel=2e-2)
            continue
        assert EI * law(k) == pytest.approx(tau, rel=1e-11)
        np.testing.assert_allclose(pose[:2], [math.sin(k * L) / k, (math.cos(k * L) - 1.0) / k], rtol=0, atol=1e-12)


def test_a_neo_hookean_section_is_stiffer_when_compressed():
    """At the tip of a straight column under a push, a small couple turns by tau times the column's compliance."""
    push, tau = -300.0, 1e-5
    p = laws.named(Mechanism())
    stretch = np.linspace(0.9, 1.0, 200001)
    axial = section.section(p, 0.0, np.stack([stretch, 0.0 * stretch, 0.0 * stretch]))[0]
    g = np.interp(push, axial, stretch)
    for c in (0.0, 1.0):
        (pose,) = poses(WEIGHTLESS.replace(neo_hookean_section=c), fx_N=[push], tau_Nm=[tau])
        stiff = EI * (1.0 + c * ((1.0 + 2.0 * g**-3) / 3.0 - 1.0))
        # beam-column: EI theta'' = -P (g + P/GA) theta with a couple at the tip: theta = tau/(EI w) tan(w L)
        w = math.sqrt(-push * (g - push / GA) / stiff)
        assert pose[2] == pytest.approx(tau / (stiff * w) * math.tan(w * L), rel=1e-6)
        assert pose[0] == pytest.approx(g * L, rel=1e-9)


def test_axial_laws_of_rubber():
    """Closed form: Mooney-Rivlin and Ogden forces at given stretches."""
    stretch = np.array([0.8, 0.9, 1.1])
    base = EA / 3.0 * (stretch - stretch**-2)
    for effect, force in (
        ({"mooney_rivlin": 0.3}, base * (1.0 + 0.3 * (1.0 / stretch - 1.0))),
        ({"ogden": 1.0}, 2.0 * EA / 9.0 * (stretch**2 - stretch**-2.5)),
        ({"beam_length": 0.01}, base),
    ):
        long = 0.028 + effect.get("beam_length", 0.0)
        found = poses(WEIGHTLESS.replace(length=0.028, **effect), fx_N=force)
        np.testing.assert_allclose(found, np.outer(long * stretch, [1.0, 0.0, 0.0]), rtol=0, atol=1e-14)


def test_shear_laws_under_a_small_side_force():
    """Closed form: the small deflection of a Timoshenko beam, and the law at one strain."""
    force = 1e-3
    (pose,) = poses(WEIGHTLESS.replace(shear_compression=1.0), fz_N=[force])
    assert pose[1] == pytest.approx(force * (L**3 / (3.0 * EI) + L / GA), rel=1e-9)
    p = laws.named(Mechanism().replace(shear_cubic=45.0))
    Q = section.section(p, 0.0, np.array([[1.0], [0.03], [0.0]]))[1, 0]
    assert pytest.approx(GA * 0.03 * (1.0 + 45.0 * 0.03**2), rel=1e-14) == Q


def test_an_s_shaped_beam_rests_in_its_shape():
    """SciPy's quad of the unloaded shape."""
    a = 0.6
    (pose,) = poses(WEIGHTLESS.replace(precurvature_gradient=a), lam_l_N=[0.0])

    def theta(s):
        return a * (s * s / L - s)

    x, z = (integrate.quad(lambda s, f=f: f(theta(s)), 0.0, L, epsabs=1e-15)[0] for f in (np.cos, np.sin))
    np.testing.assert_allclose(pose, [x, -z, 0.0], rtol=0, atol=1e-13)


def test_ends_that_are_bonded_bend_less():
    """SciPy's quad of the curvature under a couple."""
    a, decay, tau = 0.3, 0.02, 5.0
    (pose,) = poses(WEIGHTLESS.replace(**{"bonded_ends.size": a, "bonded_ends.decay": decay}), tau_Nm=[tau])
    turned = integrate.quad(
        lambda s: tau / EI / (1.0 + a * (math.exp(-s / decay) + math.exp(-(L - s) / decay))), 0.0, L, epsabs=1e-14
    )[0]
    assert pose[2] == pytest.approx(turned, abs=1e-11)


def test_clamp_and_plate_turn_by_their_couple():
    """Closed form: a compliant end turns by couple times compliance."""
    tau, c = 6.0, 2e-3
    (rigid,) = poses(WEIGHTLESS, tau_Nm=[tau])
    (at_foot,) = poses(WEIGHTLESS.replace(clamp_rotation_compliance=c), tau_Nm=[tau])
    (at_plate,) = poses(WEIGHTLESS.replace(plate_joint_compliance=c), tau_Nm=[tau])
    turn = c * tau
    rotation = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
    np.testing.assert_allclose(at_foot, [*(rotation @ rigid[:2]), rigid[2] + turn], rtol=0, atol=1e-12)
    np.testing.assert_allclose(at_plate - rigid, [0.0, 0.0, turn], rtol=0, atol=1e-12)


def test_a_clamp_gives_way_along_and_across():
    """Closed form: displacement is force times compliance."""
    force = {"fx_N": [-200.0], "fz_N": [30.0]}
    rigid = poses(WEIGHTLESS, **force)
    soft = WEIGHTLESS.replace(clamp_axial_compliance=1e-6, clamp_lateral_compliance=5e-6)
    np.testing.assert_allclose(poses(soft, **force) - rigid, [[-2e-4, 1.5e-4, 0.0]], rtol=0, atol=1e-13)


def test_springs_and_pulls_at_the_head_are_wrenches():
    """Equivalence: the same neck under the wrench that the springs exert."""
    neck = Mechanism().replace(side_force=2.0, lateral_spring=300.0, rotational_spring=1.5)
    loads = campaign()
    held = seen(neck, loads)
    pushed = equilibria(
        Mechanism(),
        rows(lam_l_N=loads.lam_l, lam_r_N=loads.lam_r, fz_N=2.0 - 300.0 * held[:, 1], tau_Nm=-1.5 * held[:, 2]),
    ).pose
    np.testing.assert_allclose(held, pushed, rtol=0, atol=1e-10)


def test_stops_push_back_beyond_their_angle():
    """Closed form: the couple of the bent beam and that of the stop balance."""
    tau = np.array([-18.0, -9.0, 9.0, 18.0])
    for name, acts in (("contact_stop", tau == tau), ("contact_stop_one_sided", tau > 0.0)):
        (theta,) = poses(WEIGHTLESS.replace(**{f"{name}.stiffness": 40.0, f"{name}.angle": 0.35}), tau_Nm=tau)[:, 2:].T
        beyond = np.sign(theta) * np.maximum(np.abs(theta) - 0.35, 0.0) * acts
        np.testing.assert_allclose(EI * theta / L, tau - 40.0 * beyond, rtol=1e-10)


def test_weights_are_where_the_effects_put_them():
    """Equivalence: a mechanism whose drawing has the changed number."""
    loads = {"tilt_rad": [0.3, -0.7], "lam_l_N": [50.0, 0.0], "lam_r_N": [0.0, 20.0]}
    for effect, drawn in (
        ({"head_com_sideways": 0.02}, {"head.b": 0.02}),
        ({"head_com_height": 0.03}, {"head.h": 0.08}),
        ({"beam_mass": 2.0}, {"mass_per_length": 11.47}),
        ({"beam_length": 2e-3}, {"length": 0.111}),
        ({"pulley_radius": 5e-3}, {"tendons.pulley_radius": 5e-3}),
        ({"lever_arm": 4e-3}, {"plate_half_width": 0.074}),
    ):
        there = poses(Mechanism().replace(**drawn), **loads)
        np.testing.assert_allclose(poses(Mechanism().replace(**effect), **loads), there, rtol=0, atol=1e-13)


def test_a_plate_above_the_beam_with_unequal_levers():
    """The attachments' places enter through virtual work: a dead wrench of the same forces gives the same pose."""
    height, arm, turned, lam = 6e-3, 4e-3, 0.05, (90.0, 35.0)
    neck = Mechanism().replace(attachment_height=height, lever_arm_asymmetry=arm, plate_misalignment=turned)
    (pose,) = poses(neck, lam_l_N=[lam[0]], lam_r_N=[lam[1]])
    a = pose[2] + turned
    along, across = np.array([math.cos(a), -math.sin(a)]), np.array([math.sin(a), math.cos(a)])
    total = np.zeros(3)
    for force, lever, pulley in zip(lam, (0.072, -0.068), (0.07, -0.07), strict=True):
        r = height * along + lever * across
        way = np.array([0.0, pulley]) - pose[:2] - r
        f = force * way / np.hypot(*way)
        total += [*f, r[1] * f[0] - r[0] * f[1]]
    (dead,) = poses(Mechanism(), fx_N=total[:1], fz_N=total[1:2], tau_Nm=total[2:])
    np.testing.assert_allclose(pose, dead, rtol=0, atol=1e-11)


# --- force cells and camera


def test_forces_behind_the_readings():
    """By hand: the formula of the force cells, solved for the readings."""
    r = np.array([[40.0, 160.0], [10.0, 0.0]])
    loads = rows(lam_l_N=r[:, 0], lam_r_N=r[:, 1])
    neck = Mechanism().replace(
        force_gain=0.03,
        force_gain_asymmetry=0.02,
        force_zero=1.0,
        force_zero_asymmetry=0.6,
        force_nonlinearity=0.05,
        force_crosstalk=0.01,
    )
    felt = np.column_stack(
        [
            r[:, 0] * 1.04 + 1.3 + 0.05 * r[:, 0] ** 2 / 160.0 + 0.01 * r[:, 1],
            r[:, 1] * 1.02 + 0.7 + 0.05 * r[:, 1] ** 2 / 160.0 + 0.01 * r[:, 0],
        ]
    )
    np.testing.assert_allclose(history.tendon_forces(laws.named(neck), loads).T, felt, rtol=1e-14)


def test_the_camera_step_by_step():
    """By hand: each step of the camera in complex numbers."""
    (pose,) = poses(Mechanism(), lam_l_N=[80.0], lam_r_N=[5.0])
    effects = {
        "marker_lever_x": 4e-3, "marker_lever_z": -3e-3, "lens_distortion": 2.0, "camera_keystone": 0.3,
        "camera_scale": 0.01, "camera_anisotropy": -0.02, "camera_rotation": 0.03, "camera_x_offset": 1e-3,
        "camera_z_offset": -2e-3, "marker_angle_offset": 0.01,
    }  # fmt: skip
    place = complex(*pose[:2]) + complex(4e-3, -3e-3) * complex(math.cos(pose[2]), -math.sin(pose[2]))
    place *= 1.0 + 2.0 * abs(place) ** 2
    place *= 1.0 + 0.3 * place.imag
    place = 1.01 * complex(place.real * 0.99, place.imag * 1.01)
    place = place * complex(math.cos(0.03), -math.sin(0.03)) + complex(1e-3, -2e-3)
    (found,) = poses(Mechanism().replace(**effects), lam_l_N=[80.0], lam_r_N=[5.0])
    np.testing.assert_allclose(found, [place.real, place.imag, pose[2] + 0.04], rtol=0, atol=1e-13)


# --- what came before


def past_of(**columns):
    loads = rows(**columns)
    p = laws.named(Mechanism())
    return history.Past.from_poses(p, loads, equilibria(Mechanism(), loads).pose)


def test_tendons_remember_which_way_they_were_pulled():
    """By hand: directions of six rows."""
    lam = {"lam_l_N": [10.0, 60.0, 60.0, 30.0, 30.0, 30.0], "lam_r_N": [5.0] * 6}
    past = past_of(**lam, pose_id=["a", "b", "b", "c", "d", "d"], session=["1"] * 5 + ["2"])
    assert past.pulled[0].tolist() == [1.0, 1.0, 1.0, -1.0, -1.0, 1.0]
    assert past.pulled[1].tolist() == [-1.0, -1.0, -1.0, 1.0, 1.0, -1.0]  # the stronger left one tilts the head
    assert past.begins.tolist() == [True, False, False, False, False, True]


def test_the_largest_load_so_far_and_the_time_since():
    """By hand: four rows."""
    lam = {"lam_l_N": [100.0, 20.0, 160.0, 0.0], "lam_r_N": [60.0, 20.0, 160.0, 32.0]}
    past = past_of(**lam, t_s=[100.0, 460.0, 1900.0, 4000.0], experiment=["t", "t", "t", "u"])
    np.testing.assert_allclose(past.peak, [0.5, 0.5, 1.0, 0.1], rtol=1e-15)
    np.testing.assert_allclose(past.hours, [0.0, 0.1, 0.5, 0.0], rtol=1e-15)
    assert past_of(**lam).hours.tolist() == [0.0] * 4


def test_the_slider_follows_until_it_slips():
    """By hand: five rows."""
    past = past_of(lam_l_N=[0.0] * 5, lam_r_N=[0.0] * 5)
    object.__setattr__(past, "theta", np.array([0.05, 0.3, 0.25, 0.1, -0.4]))
    np.testing.assert_allclose(past.slider(0.1), [0.5, 1.0, 0.5, -1.0, -1.0], rtol=0, atol=1e-15)


def test_memory_fades_by_1_over_e():
    """Closed form: exponential decay over one and two time constants."""
    past = past_of(lam_l_N=[0.0] * 3, lam_r_N=[0.0] * 3, dwell_s=[60.0, 60.0, 1e6])
    object.__setattr__(past, "theta", np.array([0.1, 0.1, 0.2]))
    np.testing.assert_allclose(past.gap(60.0), 0.1 * np.array([math.exp(-1.0), math.exp(-2.0), 0.0]), rtol=1e-14)


def test_an_aged_neck_is_a_new_one_of_other_stiffness():
    """Equivalence: a neck with the stiffness of that age."""
    loads = {"lam_l_N": [120.0, 40.0], "lam_r_N": [40.0, 10.0], "t_s": [0.0, 1800.0], "dwell_s": [9.0, 99.0]}
    neck = Mechanism().replace(creep=0.02, mullins_softening=0.05, stiffness_drift=0.03)
    found = poses(neck, **loads)
    for i, (decades, hour) in enumerate(((1.0, 0.0), (2.0, 0.5))):
        share = (1.0 - 0.05 * 0.5) * (1.0 + 0.03 * hour) / (1.0 + 0.02 * decades)
        new = Mechanism().replace(EA=EA * share, GA=GA * share, EI=EI * share)
        (pose,) = poses(new, lam_l_N=[loads["lam_l_N"][i]], lam_r_N=[loads["lam_r_N"][i]])
        np.testing.assert_allclose(found[i], pose, rtol=0, atol=1e-12)


def test_hysteresis_and_memory_are_couples():
    """Equivalence: a couple along the beam is a precurvature."""
    lam = {"lam_l_N": [0.0, 60.0, 20.0], "lam_r_N": [20.0, 0.0, 0.0], "dwell_s": [10.0, 20.0, 30.0]}
    past = past_of(**lam)
    a, turn = 0.3, 0.05
    for effect, couple in (
        ({"bending_hysteresis.couple": a}, a * past.slider(0.1)),
        ({"fading_memory.share": turn}, turn * EI / L * past.gap(60.0)),
    ):
        for i, found in enumerate(poses(Mechanism().replace(**effect), **lam)):
            bent = Mechanism().replace(precurvature=-float(couple[i]) / EI)
            (pose,) = poses(bent, lam_l_N=[lam["lam_l_N"][i]], lam_r_N=[lam["lam_r_N"][i]])
            np.testing.assert_allclose(found, pose, rtol=0, atol=1e-12)


def test_friction_holds_back_what_is_pulled_in():
    """Equivalence: frictionless tendons with the forces that act, by hand."""
    lam = {"lam_l_N": [50.0, 100.0, 50.0], "lam_r_N": [50.0, 50.0, 50.0]}
    pulled = past_of(**lam).pulled
    assert pulled[0].tolist() == [1.0, 1.0, -1.0]
    for effect, felt in (
        ({"tendon_coulomb_friction": 2.0}, np.array([*lam.values()]) - 2.0 * pulled),
        (
            {"tendon_capstan_friction.coefficient": 0.05, "tendon_capstan_friction.wrap": 2.0},
            np.array([*lam.values()]) * np.exp(-0.1 * pulled),
        ),
    ):
        there = poses(Mechanism(), lam_l_N=felt[0], lam_r_N=felt[1])
        np.testing.assert_allclose(poses(Mechanism().replace(**effect), **lam), there, rtol=0, atol=1e-12)


def test_drifts_grow_with_the_hours():
    """By hand: one hour of each drift."""
    columns = {"lam_l_N": [50.0, 50.0], "lam_r_N": [20.0, 20.0], "t_s": [600.0, 4200.0]}
    still = poses(Mechanism(), **columns)
    camera = poses(Mechanism().replace(camera_drift_x=3e-4, camera_drift_z=-1e-4), **columns)
    np.testing.assert_allclose(camera - still, [[0.0] * 3, [3e-4, -1e-4, 0.0]], rtol=0, atol=1e-15)
    cells = poses(Mechanism().replace(force_zero_drift=1.0, force_zero_drift_asymmetry=0.4), **columns)
    later = poses(Mechanism(), lam_l_N=[50.0, 51.2], lam_r_N=[20.0, 20.8])
    np.testing.assert_allclose(cells, later, rtol=0, atol=1e-12)
