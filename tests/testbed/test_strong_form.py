"""The simulated test bed: closed forms, tables made by other methods, identities, statistics of the instruments.

The tables carry 12 digits, made with residuals below 1e-11: that is what they can vouch for. `STIFF` is the EA = GA of
an inextensible beam: under Hooke's law its section turns exactly as that of the inextensible one, and the tip is
displaced by the integral of n / EA more.
"""

import importlib.util
import math
from dataclasses import replace
from itertools import groupby
from pathlib import Path

import numpy as np
import pytest
from scipy import integrate, stats

from ecm_fast import Mechanism
from ecm_fast.data import datasets
from ecm_fast.data.columns import COLUMNS
from ecm_fast.data.measurements import Measurements, read_measurements
from ecm_fast.errors import InputError
from ecm_fast.mechanism.catalogue import CATALOGUE
from ecm_fast.models.instruments.prediction import predict
from ecm_fast.testbed import (
    Equilibria,
    Outcome,
    Sensors,
    compression_test,
    equilibria,
    in_sequence,
    laws,
    mass_test,
    measure,
    readings,
    section,
    shear_test,
    strong_form,
    tendon_test,
    tilt_test,
)

ROOT = Path(__file__).resolve().parents[2]
TABLE = 1e-11
STIFF = 1e3
LAW = {"nh": "neo-hookean", "hooke": "hooke"}
WEIGHTLESS = Mechanism().replace(g=0.0)
ELASTICA = WEIGHTLESS.replace(length=1.0, EI=1.0, EA=STIFF, GA=STIFF, axial_law="hooke")
EFFECTS = {  # twice what the catalogue calls typical
    effect.size.name: 2.0 * effect.size.typical
    for effect in CATALOGUE.values()
    if effect.enters not in ("camera", "path")
}
CORNERED = ("bimodulus", "bending_amplitude")
"""Laws with a corner, where Gauss points lose their order."""
PARTS = ("section", "clamp", "plate", "geometry", "force", "environment", "camera", "path")
STOPS = {"effects.contact_stop.angle": 0.2, "effects.contact_stop_one_sided.angle": 0.15}


def rows(**columns):
    return Measurements.from_columns(columns)


def poses(mechanism, **columns):
    return equilibria(mechanism, rows(**columns)).raise_if_failed().pose


def in_groups(entries, *keys):
    """Yield the values of some columns, and the rows that share them."""

    def key(row):
        return tuple(row[name] for name in keys)

    for values, group in groupby(sorted(entries, key=key), key):
        yield *values, list(group)


def column(entries, *names):
    return np.array([[row[name] for name in names] for row in entries]).squeeze()


# --- the tables


def test_dead_tip_wrenches_on_the_paper_beam(table):
    """Shooting: the table, made by another program."""
    for law, length, group in in_groups(table("paper_beam_dead_tip_wrench"), "law", "L_m"):
        wrench = dict(zip(("fx_N", "fz_N", "tau_Nm"), column(group, "fx_N", "fz_N", "tau_Nm").T, strict=True))
        found = poses(WEIGHTLESS.replace(length=length, axial_law=LAW[law]), **wrench)
        assert np.abs(found - column(group, "x_L_m", "z_L_m", "theta_L_rad")).max() < TABLE


def test_tendon_equilibria(table):
    """Shooting: the table, made by another program."""
    count = 0
    for law, length, routing, mass, h, b, per_length, group in in_groups(
        table("tendon_equilibria"), "law", "L", "routing", "mH", "h", "b", "rhoA"
    ):
        pulley = {"pulley_z": 0.0645, "pulley_radius": 0.0055} if routing == "pulley" else {}
        neck = Mechanism().replace(
            **{
                "length": length,
                "axial_law": LAW[law],
                "mass_per_length": per_length,
                "head.mass": mass,
                "h": h,
                "b": b,
            },
            **{f"tendons.{name}": value for name, value in pulley.items()},
        )
        found = poses(neck, lam_l_N=column(group, "lambda_l"), lam_r_N=column(group, "lambda_r"))
        assert np.abs(found - column(group, "x_L", "z_L", "theta_L_rad")).max() < TABLE
        count += len(group)
    assert count == 112


@pytest.mark.slow
def test_force_and_moment_on_a_long_beam(table):
    """Shooting: the table, made by another program."""
    entries = [row for row in table("cantilever_force_and_moment") if row["law"] == "hooke"]
    for EA, GA, group in in_groups([row for row in entries if row["GA"] > 0.0], "EA", "GA"):
        beam = WEIGHTLESS.replace(length=2.0 * np.pi, EI=2.0, EA=EA, GA=GA, axial_law="hooke")
        found = poses(beam, fz_N=-column(group, "P"), tau_Nm=-column(group, "M"))
        assert np.abs(found - column(group, "x_L", "z_L", "theta_L_rad")).max() < 1e-10  # on a length of 6.28


@pytest.mark.slow
def test_elastica_under_an_inclined_load(table):
    """Shooting: the table of the inextensible elastica."""
    entries = table("elastica_inclined_tip_load")
    angle, alpha = np.radians(column(entries, "psi_deg")), column(entries, "alpha")
    force = np.array([alpha * np.cos(angle), alpha * np.sin(angle)])
    found = poses(ELASTICA, fx_N=force[0], fz_N=force[1])
    found[:, :2] -= force.T / STIFF
    assert np.abs(found - column(entries, "x_over_L", "z_over_L", "theta_tip_rad")).max() < TABLE


@pytest.mark.slow
def test_heavy_elastica_weight_and_tilt(table):
    """Shooting: the table of the heavy elastica."""
    entries = table("heavy_elastica_horizontal")
    known = column(entries, "x_over_L", "sag_over_L", "slope_tip_rad") * [1.0, -1.0, 1.0]
    for beta, pose in zip(column(entries, "beta"), known, strict=True):
        (found,) = poses(
            ELASTICA.replace(g=9.81, mass_per_length=beta / 9.81, **{"head.mass": 0.0}), tilt_rad=[np.pi / 2]
        )
        (turned,) = poses(
            ELASTICA.replace(g=9.81, mass_per_length=beta / 9.81, **{"head.mass": 0.0, "gravity.tilt": np.pi / 2}),
            fz_N=[0.0],
        )
        assert turned == pytest.approx(found, abs=1e-12)
        found[1] += beta / (2.0 * STIFF)
        assert np.abs(found - pose).max() < TABLE


def test_pure_bending_is_a_circle(table):
    """Closed form: the table of circles."""
    entries = table("pure_bending_circle")
    angle = 2.0 * np.pi * column(entries, "circle_fraction")
    found = poses(ELASTICA, tau_Nm=angle)
    known = np.array([column(entries, "x_over_L"), -column(entries, "abs_z_over_L"), angle]).T
    assert np.abs(found - known).max() < TABLE


@pytest.mark.slow
def test_a_column_fails_at_its_buckling_load(table):
    """Closed form: the critical load of the shear-flexible compressible column."""
    step = 1.0 / 1024.0  # the smallest load step
    for row in table("buckling_clamped_free_shear_compressible"):
        column_ = WEIGHTLESS.replace(length=row["L_m"])
        critical = np.array([row["P_nh"]])
        below = equilibria(column_, rows(fx_N=-critical * (1.0 - 1e-6)))
        above = equilibria(column_, rows(fx_N=-critical * 1.25))
        assert below.stable.all()
        assert above.outcome.tolist() == [Outcome.UNSTABLE]
        assert 1.0 / 1.25 - 2.0 * step <= above.load_factor[0] <= 1.0 / 1.25
        assert np.isnan(above.pose).all()


# --- closed forms


def test_compression():
    """Closed form: both axial laws."""
    stretch = np.array([0.8, 0.9, 1.0, 1.1])
    for law, force in (("neo-hookean", 2500.0 * (stretch - stretch**-2)), ("hooke", 7500.0 * (stretch - 1.0))):
        found = poses(WEIGHTLESS.replace(length=0.028, axial_law=law), fx_N=force)
        np.testing.assert_allclose(found, np.outer(0.028 * stretch, [1.0, 0.0, 0.0]), rtol=0, atol=1e-14)


def test_a_small_side_force_is_timoshenko():
    """Closed form: the linear Timoshenko beam."""
    L, EI, GA = 0.109, 3.0, 2420.0
    force = np.array([1e-4, 1e-3])
    found = poses(WEIGHTLESS, fz_N=force)
    np.testing.assert_allclose(found[:, 1], force * (L**3 / (3.0 * EI) + L / GA), rtol=1e-9)
    np.testing.assert_allclose(found[:, 2], -force * L**2 / (2.0 * EI), rtol=1e-9)


def test_a_precurved_beam_rests_as_an_arc():
    """Closed form: a circular arc."""
    k, L = 0.4, 0.109
    (found,) = poses(WEIGHTLESS.replace(precurvature=k), lam_l_N=[0.0])
    np.testing.assert_allclose(found, [math.sin(k * L) / k, (math.cos(k * L) - 1.0) / k, k * L], rtol=0, atol=1e-14)


def test_an_offset_neutral_axis_keeps_its_length_in_pure_bending():
    """Closed form: an arc shortened by offset times curvature."""
    e, k, L = 2e-3, 3.0, 0.109
    (found,) = poses(WEIGHTLESS.replace(neutral_axis_offset=e), tau_Nm=[3.0 * k])
    shorter = 1.0 - e * k
    known = [shorter * math.sin(k * L) / k, shorter * (math.cos(k * L) - 1.0) / k, k * L]
    np.testing.assert_allclose(found, known, rtol=0, atol=1e-13)


# --- identities


def test_a_turned_clamp_is_a_turned_world():
    """Frame indifference: clamp and force turned together."""
    a, wrench = 0.3, np.array([[-200.0, 50.0, 4.0], [10.0, -70.0, -8.0]])
    turn = np.array([[math.cos(a), math.sin(a)], [-math.sin(a), math.cos(a)]])
    there = poses(WEIGHTLESS, **dict(zip(("fx_N", "fz_N", "tau_Nm"), wrench.T, strict=True)))
    force = wrench[:, :2] @ turn.T
    here = poses(WEIGHTLESS.replace(clamp_tilt=a), fx_N=force[:, 0], fz_N=force[:, 1], tau_Nm=wrench[:, 2])
    np.testing.assert_allclose(here, np.column_stack([there[:, :2] @ turn.T, there[:, 2] + a]), rtol=0, atol=1e-12)


def test_mass_at_the_plate_is_a_dead_force_and_gravity_may_turn():
    """Equivalence: the weight as a dead force at Q."""
    neck = Mechanism().replace(**{"head.h": 0.0, "head.mass": 0.0, "beam.mass_per_length": 0.0})
    tilt, mass = np.array([0.7, -0.2, 0.0]), np.array([2.0, 0.5, 3.0])
    lam = {"lam_l_N": [80.0, 0.0, 30.0], "lam_r_N": [0.0, 120.0, 0.0]}
    hung = poses(neck, tilt_rad=tilt, extra_mass_kg=mass, **lam)
    pushed = poses(neck, fx_N=-9.81 * mass * np.cos(tilt), fz_N=-9.81 * mass * np.sin(tilt), **lam)
    np.testing.assert_allclose(hung, pushed, rtol=0, atol=1e-13)


@pytest.mark.slow
def test_effects_that_only_change_a_number_of_the_drawing():
    """Equivalence: a mechanism drawn with the changed number, to the bit."""
    loads = {"lam_l_N": [80.0, 10.0], "lam_r_N": [0.0, 150.0]}
    neck = Mechanism().replace(**{"tendons.pulley_radius": 0.0055, "head.b": 0.01})
    for effect, drawn in (
        ({"pulley_height": 3e-3}, {"pulley_x": 3e-3}),
        ({"pulley_spacing": -2e-3}, {"pulley_z": 0.068}),
        ({"head_mass": 0.3}, {"head.mass": 1.3}),
    ):
        np.testing.assert_array_equal(poses(neck.replace(**effect), **loads), poses(neck.replace(**drawn), **loads))
    tilted = poses(neck.replace(gravity_tilt=0.2), **loads)
    np.testing.assert_array_equal(tilted, poses(neck, tilt_rad=[0.2, 0.2], **loads))
    assert np.abs(tilted - poses(neck, **loads)).max() > 1e-4


@pytest.mark.slow
def test_the_mirror_image_of_every_neck():
    """Mirror symmetry, for every effect."""
    lam = np.random.default_rng(5).uniform(0.0, 160.0, (20, 2))
    neck = Mechanism().replace(**{"tendons.pulley_radius": 0.0055, "pulley_z": 0.0645, "head.b": 0.02})
    assert {effect.name for effect in CATALOGUE.values() if effect.mirror == "mixed"} == {"contact_stop_one_sided"}
    for name, size in {"none": 0.0, **EFFECTS}.items():
        if name.startswith("contact_stop_one_sided"):
            continue
        effect = {} if name == "none" else {name: size}
        sign = -1.0 if effect and CATALOGUE[name.partition(".")[0]].mirror == "odd" else 1.0
        mirrored = {key: sign * value for key, value in effect.items()}
        one = poses(neck.replace(**effect), lam_l_N=lam[:, 0], lam_r_N=lam[:, 1], tau_Nm=np.full(20, 0.5))
        other = poses(
            neck.replace(**{"head.b": -0.02}, **mirrored),
            lam_l_N=lam[:, 1],
            lam_r_N=lam[:, 0],
            tau_Nm=np.full(20, -0.5),
        )
        np.testing.assert_allclose(other, one * [1.0, -1.0, -1.0], rtol=0, atol=1e-12, err_msg=name)


@pytest.mark.slow
def test_the_load_steps_and_the_company_do_not_matter():
    """Contract: the answer depends on neither load steps nor other rows."""
    loads = tendon_test(40, seed=3)
    alone = equilibria(Mechanism(), loads).raise_if_failed().pose
    np.testing.assert_allclose(equilibria(Mechanism(), loads, load_steps=7).pose, alone, rtol=0, atol=1e-12)
    with_hopeless = rows(
        lam_l_N=[*loads.lam_l, 0.0, 9000.0], lam_r_N=[*loads.lam_r, 0.0, 0.0], fx_N=[*loads.fx, -5000.0, 0.0]
    )
    found = equilibria(Mechanism(), with_hopeless)
    assert found.stable.tolist() == [True] * 40 + [False, False]
    np.testing.assert_allclose(found.pose[:40], alone, rtol=0, atol=1e-12)


# --- against the model


def against(effects, elements, order, seed=11):
    """Return by how much the model misses the test bed, over random loads in an order with times."""
    neck = Mechanism().replace(**{"tendons.pulley_radius": 0.0055, "pulley_z": 0.0645, "head.b": 0.01}, **effects)
    rng = np.random.default_rng(seed)
    lam, dwell = rng.uniform(0.0, 160.0, (40, 2)), rng.uniform(5.0, 120.0, 40)
    loads = rows(
        lam_l_N=lam[:, 0],
        lam_r_N=lam[:, 1],
        tilt_rad=rng.uniform(-0.7, 0.7, 40),
        extra_mass_kg=rng.uniform(0.0, 2.0, 40),
        t_s=np.cumsum(dwell + 5.0),
        dwell_s=dwell,
        pose_id=[str(i // 2) for i in range(40)],
        session=["1"] * 25 + ["2"] * 15,
    )
    # elements must end where the stiffness jumps
    L = laws.length(laws.named(neck))
    ends = np.unique([*np.linspace(0.0, L, elements + 1), *section.jumps(laws.named(neck))])
    data = measure(neck, loads, Sensors.perfect())
    here = np.abs(predict(neck, data, elements=np.diff(ends), order=order).residual).max()
    return here, np.abs(predict(neck.replace(**dict.fromkeys(effects, 0.0)), data).residual).max() if effects else None


def test_the_model_meets_the_test_bed_to_its_own_error():
    """Two methods: finite elements and shooting, to the discretization's error."""
    assert against({}, 1, 5)[0] < 1e-8
    assert against({}, 8, 6)[0] < 1e-11


@pytest.mark.parametrize("part", [*PARTS, pytest.param("all", marks=pytest.mark.slow)])
def test_the_model_has_the_same_effects_as_the_test_bed(part):
    """Two methods: finite elements and shooting, with all effects of a part."""
    chosen = [effect for effect in CATALOGUE.values() if part in (effect.enters, "all")]
    effects = {effect.size.key: effect.size.typical for effect in chosen if effect.name not in CORNERED}
    missed, absent = against(effects, 8, 6)
    assert missed < 1e-10
    assert absent > 1e-4
    if part in ("environment", "all"):  # stops that are touched in most rows
        assert against(effects | STOPS, 8, 6)[0] < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize("name", CORNERED)
def test_the_model_meets_the_test_bed_at_corners_of_a_law(name):
    """Two methods, at laws with a corner: to a hundredth of the camera's noise."""
    missed, absent = against({name: 2.0 * CATALOGUE[name].size.typical}, 8, 6)
    assert missed < 1e-6  # a hundredth of the camera's noise
    assert absent > 1e-3


# --- what fails is said


def test_a_row_beyond_its_buckling_load_is_named():
    """Closed form: 539.05 N; and the text of the error."""
    loads = rows(fx_N=[0.0, -100.0, -700.0, -800.0])
    found = equilibria(WEIGHTLESS, loads)
    assert found.outcome.tolist() == [Outcome.STABLE, Outcome.STABLE, Outcome.UNSTABLE, Outcome.UNSTABLE]
    assert repr(found) == "<Equilibria of 4 rows: 2 stable, 2 unstable, 0 lost>"
    with pytest.raises(InputError) as caught:
        measure(WEIGHTLESS, loads)
    # 539.05 N of 700 N is 0.7701
    assert str(caught.value) == (
        "measurements: row 3: buckles or snaps at 0.77 of its load, and 1 more rows fail; "
        "lower the load or leave the row out"
    )


@pytest.mark.slow
def test_a_tendon_pulled_up_to_its_pulley_is_lost():
    """Contract: the outcome, the load factor and the text of the error."""
    found = equilibria(Mechanism(), rows(lam_l_N=[9000.0, 0.0], lam_r_N=[0.0, 0.0]))
    assert found.outcome.tolist() == [Outcome.LOST, Outcome.STABLE]
    assert 0.0 < found.load_factor[0] < 1.0
    with pytest.raises(InputError, match=r"^measurements: row 1: no equilibrium beyond 0\.\d+ of its load "):
        found.raise_if_failed()


@pytest.mark.slow
@pytest.mark.timeout(120)
def test_a_section_that_gives_way_is_reported():
    """EI (kappa - 0.0048 m^2 kappa^3) bears no more than its couple at 8.3 / m, which one tendon exceeds."""
    neck = Mechanism().replace(neo_hookean_section=-1.63, bending_cubic=-0.0048)
    found = equilibria(neck, rows(lam_l_N=[160.0, 40.0]))
    assert found.outcome[0] != Outcome.STABLE
    assert found.outcome[1] == Outcome.STABLE


def test_an_effect_without_a_law_is_refused(monkeypatch):
    """Contract: the text of the error."""
    monkeypatch.setattr(laws, "BUILT_IN", laws.BUILT_IN - {"precurvature"})
    with pytest.raises(
        InputError, match=r"^effects\.precurvature = 0\.2: the test bed has no law for it; allowed are "
    ):
        measure(Mechanism().replace(precurvature=0.2), tendon_test(2))


def test_the_laws_are_named_as_in_the_catalogue():
    """Contract: the same names."""
    assert set(CATALOGUE) == laws.BUILT_IN


# --- a further effect is one function: laws that the catalogue does not hold yet, against closed forms


def test_a_stiffness_that_tapers_along_the_beam(monkeypatch):
    """SciPy's quad of the curvature under a couple."""
    a, L, EI, tau = 0.3, 0.109, 3.0, 9.0
    monkeypatch.setattr(section, "stiffness", lambda p, s: (7500.0, 2420.0, EI / (1.0 + a * s / L)))
    (found,) = poses(WEIGHTLESS, tau_Nm=[tau])

    def theta(s):
        return tau / EI * (s + a * s**2 / (2.0 * L))

    x, z = (integrate.quad(lambda s, f=f: f(theta(s)), 0.0, L, epsabs=1e-14)[0] for f in (np.cos, np.sin))
    np.testing.assert_allclose(found, [x, -z, theta(L)], rtol=0, atol=1e-13)


def test_a_clamp_that_gives_way(monkeypatch):
    """Closed form: displacement and rotation are force and couple times compliance."""
    turn, give, tau, push = 2e-3, 5e-6, 6.0, -300.0
    heavy = Mechanism().replace(**{"head.mass": 0.0})

    def soft(p, force, couple):
        return np.stack([give * force[0], 0.0 * couple, turn * couple])

    rigid = poses(heavy, fx_N=[push])
    monkeypatch.setattr(strong_form, "clamp", soft)
    (bent,) = poses(WEIGHTLESS, tau_Nm=[tau])
    start, k, L = turn * tau, tau / 3.0, 0.109
    end = start + k * L
    arc = [(math.sin(end) - math.sin(start)) / k, (math.cos(end) - math.cos(start)) / k, end]
    np.testing.assert_allclose(bent, arc, rtol=0, atol=1e-13)
    sinks = give * (push - 9.47 * 9.81 * L)  # the foot carries the push and the whole beam
    np.testing.assert_allclose(poses(heavy, fx_N=[push]) - rigid, [[sinks, 0.0, 0.0]], rtol=0, atol=1e-14)


def test_a_section_law_without_inverse(monkeypatch):
    """SciPy's root of the law under a couple."""
    a, tau = 4e-3, np.array([3.0, -9.0])
    own = section.section

    def stiffening(p, s, strains):
        N, Q, M = own(p, s, strains)
        return np.stack([N, Q, M + p["beam.EI"] * a * strains[2] ** 3])

    monkeypatch.setattr(strong_form, "section", stiffening)
    found = poses(WEIGHTLESS, tau_Nm=tau)
    kappa = found[:, 2] / 0.109
    np.testing.assert_allclose(3.0 * kappa * (1.0 + a * kappa**2), tau, rtol=1e-12)


# --- instruments

N = 4000


def known(pose=(0.0, 0.0, 0.0), lam=50.0):
    """Return equilibria that need no solve: one pose in N rows."""
    loads = rows(lam_l_N=np.full(N, lam), lam_r_N=np.full(N, lam / 2.0))
    return Equilibria(np.tile(pose, (N, 1)), np.zeros(N, dtype=np.int64), np.ones(N), loads)


def read(sensors, seed=0, **of):
    return readings(Mechanism(), known(**of), sensors, seed)


def within(value, distribution, chance=1e-5):
    low, high = distribution.ppf([chance, 1.0 - chance])
    assert low <= value <= high


def test_white_noise_has_the_variance_it_says():
    """Chi-squared and Kolmogorov-Smirnov tests against the normal distribution."""
    data = read(Sensors(camera_sigma=(1e-4, 3e-4, 2e-3), force_sigma=0.2), seed=1)
    for values, sigma in ((data.x, 1e-4), (data.z, 3e-4), (data.theta, 2e-3), (data.lam_l - 50.0, 0.2)):
        within(np.sum((values / sigma) ** 2), stats.chi2(N))
        assert stats.kstest(values / sigma, "norm").pvalue > 1e-4
    assert abs(np.corrcoef(data.x, data.z)[0, 1]) < 4.5 / math.sqrt(N)
    assert (data.sigma_x[0], data.sigma_z[0], data.sigma_theta[0], data.sigma_lam[0]) == (1e-4, 3e-4, 2e-3, 0.2)


def test_sigmas_may_be_kept_back():
    """Contract: no declared sigma, noise nevertheless."""
    data = read(Sensors(declared=False))
    assert np.isnan([data.sigma_x, data.sigma_z, data.sigma_theta, data.sigma_lam]).all()
    assert data.x.std() > 0.0


def test_heavy_tails_are_those_of_student():
    """Kolmogorov-Smirnov and binomial tests against Student's t."""
    noise = read(Sensors(tail_dof=3.0), seed=2).x / 1e-4
    assert stats.kstest(noise * math.sqrt(3.0), stats.t(3).cdf).pvalue > 1e-4
    within(np.sum(np.abs(noise) > 4.0), stats.binom(N, 2.0 * stats.t(3).sf(4.0 * math.sqrt(3.0))))
    within(np.sum(np.abs(read(Sensors(), seed=2).x / 1e-4) > 4.0), stats.binom(N, 2.0 * stats.norm.sf(4.0)))


def test_outliers_are_as_many_and_as_large_as_said():
    """Binomial test of their number and sign; their size exactly."""
    plain, data = read(Sensors(), seed=3), read(Sensors(outlier_share=0.05, outlier_size=20.0), seed=3)
    off = (data.pose - plain.pose) / [1e-4, 1e-4, 1e-3]
    hit = np.abs(off[:, 0]) > 1e-6
    within(hit.sum(), stats.binom(N, 0.05))
    np.testing.assert_allclose(np.abs(off[hit]), 20.0, rtol=1e-9)
    np.testing.assert_array_equal(off[~hit], 0.0)  # the other rows keep their noise
    within(np.sum(off[hit] > 0.0), stats.binom(off[hit].size, 0.5))


def test_neighboring_rows_are_correlated():
    """Theory of AR(1): correlation at lags 1 and 2, and the variance."""
    noise = read(Sensors(correlation=0.6), seed=4).pose / [1e-4, 1e-4, 1e-3]
    for values in noise.T:
        assert np.corrcoef(values[1:], values[:-1])[0, 1] == pytest.approx(0.6, abs=4.5 * math.sqrt((1 - 0.36) / N))
        assert np.corrcoef(values[2:], values[:-2])[0, 1] == pytest.approx(0.36, abs=4.5 * math.sqrt(2.0 / N))
        # the effective number of rows for the variance is N (1 - rho^2) / (1 + rho^2)
        assert np.mean(values**2) == pytest.approx(1.0, abs=4.5 * math.sqrt(2.0 / N * (1 + 0.36) / (1 - 0.36)))


def test_readings_are_multiples_of_the_resolution():
    """Rounding by hand."""
    use = Sensors(camera_resolution=(1e-4, 3e-4, 0.0), force_resolution=0.05, force_sigma=0.1)
    fine, coarse = read(replace(use, camera_resolution=(0.0,) * 3, force_resolution=0.0), seed=5), read(use, seed=5)
    for name, step in (("x", 1e-4), ("z", 3e-4), ("lam_l", 0.05)):
        values = getattr(coarse, name)
        np.testing.assert_allclose(values / step, np.round(values / step), rtol=0, atol=1e-9)
        assert 0.0 < np.abs(values - getattr(fine, name)).max() <= step / 2.0 + 1e-12
    np.testing.assert_array_equal(coarse.theta, fine.theta)
    assert {repr(float(value)) for value in coarse.lam_l} >= {"50.0", "50.05", "49.95"}  # no 50.050000000000004


def test_gain_zero_and_drift_of_the_force_cells():
    """By hand: the formula of the cells."""
    gain = {"force_gain": (1.02, 0.98), "force_zero": (1.0, -2.0), "force_drift": (0.5, -0.1)}
    data = read(replace(Sensors.perfect(), **gain))
    grown = np.linspace(0.0, 1.0, N)
    np.testing.assert_allclose(data.lam_l, 1.02 * 50.0 + 1.0 + 0.5 * grown, rtol=1e-14)
    np.testing.assert_allclose(data.lam_r, 0.98 * 25.0 - 2.0 - 0.1 * grown, rtol=1e-14)
    assert read(replace(Sensors.perfect(), force_zero=(-80.0, 0.0))).lam_l.max() == 0.0


def test_the_camera_frame():
    """By hand: rotation, scale and offset of one point."""
    a, x = 0.1, 0.109
    frame = {"camera_rotation": a, "camera_scale": 1.01, "camera_offset": (1e-3, 2e-3, 3e-3)}
    data = read(replace(Sensors.perfect(), **frame, camera_drift=(0.0, 1e-3, 0.0)), pose=(x, 0.0, -0.2))
    first = [1.01 * x * math.cos(a) + 1e-3, -1.01 * x * math.sin(a) + 2e-3, -0.2 + a + 3e-3]
    np.testing.assert_allclose(data.pose[0], first, rtol=0, atol=1e-15)
    np.testing.assert_allclose(data.pose[-1] - data.pose[0], [0.0, 1e-3, 0.0], rtol=0, atol=1e-15)


def test_the_reading_is_noisy_but_the_true_force_acts():
    """Contract: poses are those of the true forces, to the bit."""
    loads = tendon_test(20, seed=1)
    use = replace(Sensors.perfect(), force_sigma=0.4, force_zero=(1.0, 0.0))
    data = measure(Mechanism(), loads, use, seed=6)
    assert np.abs(data.lam - loads.lam).min() > 0.0
    np.testing.assert_array_equal(data.pose, equilibria(Mechanism(), loads).pose)


def test_the_seed_makes_the_noise():
    """Contract: the same seed, the same noise."""
    one, same, other = (read(Sensors(force_sigma=0.1), seed) for seed in (7, np.random.default_rng(7), 8))
    np.testing.assert_array_equal(one.pose, same.pose)
    np.testing.assert_array_equal(one.lam, same.lam)
    assert (one.pose != other.pose).all()
    np.testing.assert_array_equal(one.pose, read(Sensors(), 7).pose)  # force noise leaves the camera's as it is


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"camera_sigma": (1e-4, -1e-4, 1e-3)}, "(0.0001, -0.0001, 0.001): allowed is a finite number >= 0, 3 times"),
        ({"force_gain": (1.0,)}, "(1.0,): allowed is a finite number, 2 times"),
        ({"force_sigma": math.nan}, "nan: allowed is a finite number >= 0"),
        ({"tail_dof": 2.0}, "2.0: allowed is a number > 2, inf for Gaussian noise"),
        ({"outlier_share": 1.5}, "1.5: allowed is a number from 0 to 1"),
        ({"camera_scale": "1"}, "'1': allowed is a finite number > 0"),
        ({"correlation": True}, "True: allowed is a number from -1 to 1"),
    ],
)
def test_instruments_that_cannot_be(wrong, message):
    """Contract: the text of the error."""
    with pytest.raises(InputError) as caught:
        Sensors(**wrong)
    assert str(caught.value) == f"{next(iter(wrong))} = {message}"


# --- experiments


def test_a_tendon_test_on_a_grid_has_every_pair_once():
    """By hand: all pairs of nine levels."""
    loads = tendon_test(grid=9, seed=2)
    level = np.linspace(0.0, 160.0, 9)
    assert sorted(map(tuple, loads.lam.tolist())) == [(one, other) for one in level for other in level]
    assert sorted(map(tuple, loads.lam.tolist())) != list(map(tuple, loads.lam.tolist()))  # in random order
    assert not loads.measured.any()


def test_replicates_share_a_load_and_are_taken_at_other_times():
    """By hand: counts of rows and replicates."""
    loads = tendon_test(260, replicated=10, replicates=5, lam_max=80.0)
    assert loads.n == 300
    assert loads.lam.max() <= 80.0
    names, counts = np.unique(loads.pose_id, return_counts=True)
    assert sorted(counts.tolist()) == [1] * 250 + [5] * 10
    for name in names[counts == 5]:
        where = np.flatnonzero(loads.pose_id == name)
        assert len(np.unique(loads.lam[where], axis=0)) == 1
        assert np.diff(where).max() > 1
    assert (np.diff(loads.t) > loads.dwell[1:]).all()


def test_compression_shortens_the_specimen_as_asked():
    """By hand: 0, 5, 10, 15 and 20 % of the length."""
    for law in LAW.values():
        neck = Mechanism().replace(axial_law=law, clamp_tilt=0.1, head_mass=0.5)
        for length in (0.028, 0.040):
            specimen, loads = compression_test(length, neck, n=5)
            found = equilibria(specimen, loads).raise_if_failed().pose
            np.testing.assert_allclose(found[:, 0], length * np.array([1.0, 0.95, 0.9, 0.85, 0.8]), rtol=1e-13)
            np.testing.assert_allclose(found[:, 1:], 0.0, rtol=0, atol=1e-15)
    heavy, loads = compression_test(0.040, weight=True, n=2)
    (found, _) = equilibria(heavy, loads).raise_if_failed().pose
    # rho A g L^2 / (2 EA), to first order of a strain of 5e-4
    assert 1.0 - found[0] / 0.040 == pytest.approx(9.47 * 9.81 * 0.040 / (2.0 * 7500.0), rel=1e-3)


def test_a_specimen_keeps_what_was_cast_into_it():
    """Contract: effects of the beam stay, those of head and tendons go."""
    neck = Mechanism().replace(precurvature=0.2, pulley_shift=1e-3)
    specimen, _ = compression_test(0.028, neck)
    assert dict(specimen.effects) == {"precurvature": 0.2}
    assert (specimen.beam.length, specimen.beam.mass_per_length, specimen.head.mass) == (0.028, 0.0, 0.0)


def test_tilts_and_masses_with_every_pair_of_tendon_forces():
    """By hand: the rows of small tests."""
    tilted = tilt_test([-0.7, 0.7], [(0.0, 0.0), (80.0, 10.0)])
    assert tilted.tilt.tolist() == [-0.7, -0.7, 0.7, 0.7]
    assert tilted.lam.tolist() == [[0.0, 0.0], [80.0, 10.0]] * 2
    assert mass_test([1.0, 2.0]).extra_mass.tolist() == [1.0, 2.0]
    assert shear_test([0.0, -33.0]).fz.tolist() == [0.0, -33.0]
    assert set(tilted.experiment) == {"tilt"}


def test_experiments_in_sequence():
    """By hand: the rows of three tests in sequence."""
    both = in_sequence(shear_test([0.0, 33.0]), shear_test([0.0, 66.0]), mass_test([1.0]))
    assert both.fz.tolist() == [0.0, 33.0, 0.0, 66.0, 0.0]
    assert both.session.tolist() == ["1", "1", "2", "2", "3"]
    assert len(set(both.pose_id)) == 5
    assert (np.diff(both.t) > both.dwell[1:]).all()
    assert both.source == "shear test and mass test"


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda: tendon_test(0), "n = 0: allowed is a whole number > 0"),
        (lambda: tendon_test(3, lam_max=-1.0), "lam_max = -1.0: allowed is a number > 0"),
        (lambda: tendon_test(3, replicated=4), "replicated = 4: allowed is a whole number from 0 to 3"),
        (lambda: compression_test(shortening=1.0), "shortening = 1.0: allowed is a number between 0 and 1"),
        (lambda: shear_test([]), "forces = []: allowed is a list of numbers"),
        (lambda: tilt_test([0.1], [1.0, 2.0]), "lam = [1.0, 2.0]: allowed is pairs of tendon forces, shape (k, 2)"),
        (in_sequence, "no experiments to do in sequence; name at least one"),
    ],
)
def test_experiments_that_cannot_be(ask, message):
    """Contract: the text of the error."""
    with pytest.raises(InputError) as caught:
        ask()
    assert str(caught.value) == message


def test_a_bad_load_is_named_with_its_row():
    """Contract: the text of the error."""
    with pytest.raises(InputError, match=r"^shear test: row 2, column fz_N: inf "):
        shear_test([1.0, math.inf])
    with pytest.raises(InputError, match=r"^mass test: row 1, column extra_mass_kg: -1\.0 "):
        mass_test([-1.0])


# --- files


def test_measurements_survive_a_file(tmp_path):
    """Round trip: every column, every digit."""
    loads = in_sequence(tendon_test(6), tilt_test([0.3], [(10.0, 20.0)]), mass_test([1.5]), shear_test([9.0]))
    data = measure(Mechanism(), loads, Sensors(force_sigma=0.1), seed=9)
    again = read_measurements(data.to_csv(tmp_path / "run.csv", "SIMULATED"))
    for name in COLUMNS:
        np.testing.assert_array_equal(getattr(again, name), getattr(data, name), err_msg=name)


def test_a_row_without_equilibrium_is_blank_in_readings():
    """Contract: blank channels for such a row."""
    found = equilibria(WEIGHTLESS, rows(fx_N=[0.0, -800.0]))
    assert readings(WEIGHTLESS, found).measured.tolist() == [[True] * 3, [False] * 3]


@pytest.fixture(scope="module")
def writer():
    spec = importlib.util.spec_from_file_location("make_datasets", ROOT / "tools" / "make_datasets.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
def test_the_shipped_campaigns_are_what_their_writer_writes(writer, tmp_path):
    """Contract: the files are current, and a changed one is noticed."""
    assert writer.stale(writer.FOLDER) == []
    writer.write(tmp_path)
    path = tmp_path / "simulated_paper_shear.csv"
    path.write_text(path.read_text(encoding="utf-8").replace("3.0", "3.1", 1), encoding="utf-8")
    (tmp_path / "simulated_paper_shear.toml").unlink()
    assert writer.stale(tmp_path) == ["simulated_paper_shear.csv", "simulated_paper_shear.toml"]


def test_the_shipped_campaigns_are_small():
    """Contract: less than 300 kB in all."""
    files = list((ROOT / "ecm_fast" / "data" / "datasets" / "simulated").iterdir())
    assert len(files) == 12
    assert sum(path.stat().st_size for path in files) < 300_000


@pytest.mark.parametrize("name", ["slender_shear", "paper_shear", "compression_28mm", "compression_40mm"])
def test_the_truth_explains_a_shipped_campaign_to_its_noise(name):
    """Chi-squared: residuals of the stated truth."""
    mechanism, data = datasets.load(f"simulated_{name}")
    sigma = np.column_stack([data.sigma_x, data.sigma_z, data.sigma_theta])
    within(np.sum((predict(mechanism, data).residual / sigma) ** 2), stats.chi2(sigma.size))


@pytest.mark.parametrize("preset", ["slender", "paper"])
def test_the_shipped_tendon_tests(preset):
    """Counting, and the scatter of repeated loads against the declared noise."""
    mechanism, data = datasets.load(f"simulated_{preset}_tendon")
    assert mechanism == Mechanism.preset(preset)
    assert data.n == 300
    counts = np.unique(data.pose_id, return_counts=True)[1]
    assert sorted(counts.tolist()) == [1] * 250 + [5] * 10
    # the scatter of repeated loads, free of any model, is the noise the file declares
    pure = sum(
        np.sum((data.pose[same] - data.pose[same].mean(axis=0)) ** 2 / [1e-8, 1e-8, 1e-6])
        for same in (data.pose_id == name for name in np.unique(data.pose_id))
        if same.sum() > 1
    )
    within(pure, stats.chi2(3 * 10 * 4))
