"""The solver against the tables of `tests/tables`: shooting, elliptic integrals and closed forms, no finite elements.

The tables carry 12 digits and were made with residuals below 1e-11, so 1e-11 (m, rad) is what they can vouch for.

Inextensible, unshearable tables are met without a huge stiffness. Under Hooke's law with EA = GA the strain is
n / EA whatever the section's angle: it adds n / EA to r', which has no moment with n, so theta(s) is exactly that of
the inextensible beam, and the tip is displaced by the integral of n / EA more. `STIFF` is that EA = GA.
"""

import numpy as np
import pytest

from ecm_fast import FiniteElementModel, Mechanism, Status
from ecm_fast.mechanism.vector import pack
from ecm_fast.models import reference

TABLE = 1e-11
STIFF = 1e3
LAW = {"nh": "neo-hookean", "hooke": "hooke"}
P_EULER = np.pi**2 / 4.0  # of the clamped-free column with L = EI = 1


def beam(**changes):
    """Return a beam that weighs nothing, resolved until the tables are all that limits."""
    return FiniteElementModel(Mechanism().replace(**{"g": 0.0} | changes), elements=8, order=6)


def elastica(**changes):
    """Return the inextensible beam of unit length and bending stiffness, see above."""
    return beam(**{"length": 1.0, "EI": 1.0, "EA": STIFF, "GA": STIFF, "axial_law": "hooke"} | changes)


def stable_pose(model, lam=(0.0, 0.0), wrench=(0.0, 0.0, 0.0)):
    """Return the pose of an equilibrium that must be stable."""
    return model.solve(lam, wrench).raise_if_failed().pose


@pytest.mark.parametrize(
    ("name", "rows"),
    [
        ("axial_compression_closed_form", 18),
        ("buckling_clamped_free_shear_compressible", 9),
        ("cantilever_force_and_moment", 27),
        ("elastica_inclined_tip_load", 20),
        ("elastica_postbuckling_clamped_free", 11),
        ("elastica_transverse_tip_load", 19),
        ("follower_transverse_tip_force", 16),
        ("heavy_elastica_horizontal", 9),
        ("paper_beam_dead_tip_wrench", 100),
        ("pure_bending_circle", 7),
        ("tendon_equilibria", 112),
    ],
)
def test_every_table_is_whole(table, name, rows):
    """The tables as they came: no row may get lost, or the tests below pass on less than they say."""
    assert len(table(name)) == rows


def test_dead_tip_wrenches_on_the_paper_beam(table):
    """Shooting at 1e-13: both lengths, both axial laws, wrenches over the paper's whole box."""
    errors = []
    for row in table("paper_beam_dead_tip_wrench"):
        model = beam(length=row["L_m"], axial_law=LAW[row["law"]])
        pose = stable_pose(model, wrench=(row["fx_N"], row["fz_N"], row["tau_Nm"]))
        errors.append(pose - [row["x_L_m"], row["z_L_m"], row["theta_L_rad"]])
    assert np.abs(errors).max() < TABLE


def test_tendon_equilibria(table):
    """Shooting at 1e-13: point and finite pulleys, with and without the weight of beam and head."""
    errors, wrench_errors = [], []
    for row in table("tendon_equilibria"):
        changes = {"length": row["L"], "axial_law": LAW[row["law"]], "mass_per_length": row["rhoA"]}
        changes |= {"head.mass": row["mH"], "h": row["h"], "b": row["b"]}
        if row["routing"] == "pulley":
            changes |= {"pulley_z": 0.0645, "tendons.pulley_radius": 0.0055}
        mechanism = Mechanism().replace(**changes)
        lam = (row["lambda_l"], row["lambda_r"])
        pose = stable_pose(FiniteElementModel(mechanism, elements=8, order=6), lam)
        errors.append(pose - [row["x_L"], row["z_L"], row["theta_L_rad"]])
        # no share of gravity: the table's wrench is that of the tendons alone
        wrench = reference.tip_wrench(reference.named(pack(mechanism)), (*lam, 0.0, 0.0, 0.0, 0.0), pose)
        wrench_errors.append(wrench - [row["fx"], row["fz"], row["tau"]])
    assert np.abs(errors).max() < TABLE
    assert np.abs(wrench_errors).max() < 1e-9  # the twelfth digit of 320 N


def test_axial_compression(table):
    """Closed form: the compression test of the paper, with the stiffnesses of its Table 1."""
    stiffness = {0.028: (7448.94, 8972.10), 0.040: (7591.09, 9071.84)}
    for row in table("axial_compression_closed_form"):
        for law, EA, key in zip(("neo-hookean", "hooke"), stiffness[row["L_m"]], ("f_nh_N", "f_hooke_N"), strict=True):
            pose = stable_pose(beam(length=row["L_m"], EA=EA, axial_law=law), wrench=(-row[key], 0.0, 0.0))
            assert abs(pose[0] / row["L_m"] - row["g"]) < TABLE
            assert pose[1] == pose[2] == 0.0


def test_shear_flexible_cantilever_under_force_and_moment(table):
    """Shooting: EA = 5, GA = 1, EI = 2, so soft that stretch and shear are of the order of 1."""
    model = beam(length=2.0 * np.pi, EI=2.0, EA=5.0, GA=1.0, axial_law="hooke")
    rows = [row for row in table("cantilever_force_and_moment") if row["GA"] == 1.0]
    poses = [stable_pose(model, wrench=(0.0, -row["P"], -row["M"])) for row in rows]
    errors = np.array(poses) - [[row["x_L"], row["z_L"], row["theta_L_rad"]] for row in rows]
    assert len(rows) == 9
    assert np.abs(errors).max() < TABLE


def test_extensible_cantilever_under_force_and_moment(table):
    """Shooting: EA = 5 and no shear (GA is 0 in the table); GA = 1e6 shears by P L / GA = 3.2e-6 at most."""
    model = beam(length=2.0 * np.pi, EI=2.0, EA=5.0, GA=1e6, axial_law="hooke")
    rows = [row for row in table("cantilever_force_and_moment") if row["law"] == "hooke" and row["GA"] == 0.0]
    poses = [stable_pose(model, wrench=(0.0, -row["P"], -row["M"])) for row in rows]
    errors = np.array(poses) - [[row["x_L"], row["z_L"], row["theta_L_rad"]] for row in rows]
    assert len(rows) == 9
    assert np.abs(errors).max() < 3.2e-6


def test_inextensible_cantilever_under_force_and_moment(table):
    """Shooting, and the published analytic centerlines of Harsch 2021; the tip is P L / EA lower, see above."""
    length, stiff = 2.0 * np.pi, STIFF * 2.0 / (2.0 * np.pi) ** 2
    model = beam(length=length, EI=2.0, EA=stiff, GA=stiff, axial_law="hooke")
    rows = [row for row in table("cantilever_force_and_moment") if row["law"] == "inext"]
    poses = [stable_pose(model, wrench=(0.0, -row["P"], -row["M"])) for row in rows]
    exact = [[row["x_L"], row["z_L"] - row["P"] * length / stiff, row["theta_L_rad"]] for row in rows]
    assert len(rows) == 9
    assert np.abs(np.array(poses) - exact).max() < 2 * TABLE  # lengths up to 6.2: one digit less behind the point


def test_elastica_under_a_transverse_load(table):
    """Elliptic integrals (Bisshopp & Drucker 1945; Mattiasson 1981), to P L^2 / EI = 50."""
    model, errors = elastica(), []
    for row in table("elastica_transverse_tip_load"):
        force = row["alpha"]
        exact = [1.0 - row["u_over_L"], row["w_over_L"] + force / STIFF, -row["theta_tip_rad"]]
        errors.append(stable_pose(model, wrench=(0.0, force, 0.0)) - exact)
    # 8 elements leave 2.2e-11 at alpha = 50, where all bending is in the first seventh of the beam
    assert np.abs(errors).max() < 3 * TABLE


def test_elastica_under_an_inclined_load(table):
    """Shooting: tip loads at 30 to 150 degrees from the beam's axis, pulling and pushing."""
    model, errors = elastica(), []
    for row in table("elastica_inclined_tip_load"):
        psi = np.deg2rad(row["psi_deg"])
        force = row["alpha"] * np.array([np.cos(psi), np.sin(psi), 0.0])
        exact = np.array([row["x_over_L"], row["z_over_L"], row["theta_tip_rad"]]) + force / STIFF
        errors.append(stable_pose(model, wrench=force) - exact)
    assert np.abs(errors).max() < TABLE


def test_elastica_under_its_own_weight(table):
    """Shooting: a horizontal beam sags; its own weight adds w L^2 / (2 EA) to the sag of the inextensible one."""
    errors = []
    for row in table("heavy_elastica_horizontal"):
        weight = {"g": 1.0, "mass_per_length": row["beta"], "head.mass": 0.0, "gravity_tilt": np.pi / 2.0}
        exact = [row["x_over_L"], -row["sag_over_L"] - row["beta"] / (2.0 * STIFF), row["slope_tip_rad"]]
        errors.append(stable_pose(elastica(**weight)) - exact)
    assert np.abs(errors).max() < 2 * TABLE  # 8 elements leave 1.7e-11 at beta = 50


@pytest.mark.parametrize("stiff", [1e6, 1e9])
def test_a_strip_of_steel_is_an_elastica(table, stiff):
    """Elliptic integrals: EA L^2 / EI is 12 (L / thickness)^2 of a strip, 1e6 for a ruler, 1e9 for a foil.

    Forces are differences of strains times EA: they round by 1e-16 EA, that is by 1e-7 here, and so does the tip.
    """
    model = elastica(EA=stiff, GA=stiff)
    for row in table("elastica_transverse_tip_load"):
        exact = [1.0 - row["u_over_L"], row["w_over_L"] + row["alpha"] / stiff, -row["theta_tip_rad"]]
        np.testing.assert_allclose(stable_pose(model, wrench=(0.0, row["alpha"], 0.0)), exact, rtol=0.0, atol=1e-7)


@pytest.mark.parametrize("law", ["neo-hookean", "hooke"])
def test_end_moment_bends_to_a_circle(table, law):
    """Closed form: no stretch, no shear, curvature M / EI; up to two full turns, on the paper's soft beam."""
    model = beam(axial_law=law)
    length, EI = model.mechanism.beam.length, model.mechanism.beam.EI
    for row in table("pure_bending_circle"):
        pose = stable_pose(model, wrench=(0.0, 0.0, row["ML_over_EI"] * EI / length))
        assert abs(pose[0] / length - row["x_over_L"]) < TABLE
        assert abs(pose[1] / length + row["abs_z_over_L"]) < TABLE
        assert abs(pose[2] - row["ML_over_EI"]) < 2 * TABLE  # the angle is rounded to half of that


def test_buckled_column(table):
    """Elliptic integrals (Timoshenko & Gere): the stable branch of a column that a tiny side force lets choose.

    The side force of 2e-7 EI / L^2 is taken out again to first order by the compliance; what is left falls with its
    square and is largest just above the critical load, 5e-8 at 5 degrees (compliance 270 rad), and below the tables'
    own error from 20 degrees on.
    """
    model, side = elastica(), 2e-7
    for row in table("elastica_postbuckling_clamped_free"):
        load = row["P_over_Pcr"] * P_EULER
        solved = model.solve(wrench=(-load, side, 0.0)).raise_if_failed()
        exact = [row["x_over_L"] - load / STIFF, row["z_over_L"], -np.deg2rad(row["theta_tip_deg"])]
        error = np.abs(solved.pose - side * solved.compliance[:, 1] - exact).max()
        assert error < (1e-7 if row["theta_tip_deg"] < 20.0 else 1e-10)


def test_column_under_a_perfectly_axial_load(table):
    """Euler: above P_cr the straight column is an equilibrium but not stable, and the branch is lost at P_cr.

    The verdict is that of the last iterate, whose axial force may be wrong by 1e-7 EI / L^2, 4e-8 of the critical
    load. Beside that, load steps end at 1e-8 of the full load, which is up to nine times the critical one.
    """
    model = elastica()
    for row in table("elastica_postbuckling_clamped_free"):
        solved = model.solve(wrench=(-row["P_over_Pcr"] * P_EULER, 0.0, 0.0))
        assert solved.status is Status.UNSTABLE
        assert abs(solved.load_factor * row["P_over_Pcr"] - 1.0) < 5e-7
        assert solved.z == solved.theta == 0.0


@pytest.mark.parametrize("stiff", [1e6, 1e8, 1e10])
def test_a_column_of_steel_buckles(stiff):
    """Euler: the critical load does not depend on EA = GA, so neither may the verdict.

    Positions are known to a few units in the last place, 1e-15 of the length; eight elements of order 6, whose shape
    functions' slopes add up to 220, turn that into 2e-13 of the stretch, so 2e-13 EA of the axial force.
    """
    model = elastica(EA=stiff, GA=stiff)
    for times in (1.001, 1.3, 4.0):
        solved = model.solve(wrench=(-times * P_EULER, 0.0, 0.0))
        assert solved.status is Status.UNSTABLE
        assert abs(times * solved.load_factor - 1.0) < max(1e-7, 2e-13 * stiff / P_EULER)


@pytest.mark.parametrize(("law", "key"), [("neo-hookean", "P_nh"), ("hooke", "P_hooke")])
def test_buckling_of_the_shear_flexible_compressible_column(table, law, key):
    """Closed form: P (g(P) + P / GA) = pi^2 EI / (4 L^2), from L = 0.028 m (stocky) to 0.5 m (slender)."""
    for row in table("buckling_clamped_free_shear_compressible"):
        model, critical = beam(length=row["L_m"], axial_law=law), row[key]
        beyond = model.solve(wrench=(-1.3 * critical, 0.0, 0.0))
        assert beyond.status is Status.UNSTABLE
        # as above, with room for the tenth digit of the table
        assert abs(1.3 * beyond.load_factor - 1.0) < 3e-7
        assert model.solve(wrench=(-(1.0 - 1e-6) * critical, 0.0, 0.0)).status is Status.CONVERGED
        assert model.solve(wrench=(-(1.0 + 1e-6) * critical, 0.0, 0.0)).status is Status.UNSTABLE


def test_a_dead_force_is_no_follower_force(table):
    """Backward shooting: the tip force keeps its direction, so the follower table is missed by far."""
    for row in table("follower_transverse_tip_force"):
        if row["alpha"] >= 1.0:
            stiffness = {"EA": STIFF, "GA": STIFF} if row["law"] == "inext" else {"EA": row["EA"], "GA": row["GA"]}
            model = beam(length=1.0, EI=1.0, axial_law="hooke", **stiffness)
            pose = stable_pose(model, wrench=(0.0, row["alpha"], 0.0))
            assert np.abs(pose - [row["x_over_L"], row["z_over_L"], row["theta_tip_rad"]]).max() > 1e-2


def test_small_tip_force_is_timoshenko():
    """Closed form of the linear beam, as a limit: what is left over falls with the square of the force."""
    model = beam()
    length, EI, GA = model.mechanism.beam.length, model.mechanism.beam.EI, model.mechanism.beam.GA
    left = []
    for force in (1.0, 0.1, 0.01):
        pose = stable_pose(model, wrench=(0.0, force, 0.0))
        z, theta = force * length**3 / (3.0 * EI) + force * length / GA, -force * length**2 / (2.0 * EI)
        left.append([pose[1] / z - 1.0, pose[2] / theta - 1.0])
    # (f L^2 / EI)^2 is 1.6e-5 at 1 N; the factor of the leading term is below one
    assert np.abs(left[0]).max() < 1.6e-5
    # at 0.01 N, 2e-10 is left of which 1e-13 may be rounding
    np.testing.assert_allclose(np.array(left[0]) / left[1], 100.0, rtol=1e-3)
    np.testing.assert_allclose(np.array(left[1]) / left[2], 100.0, rtol=1e-3)
