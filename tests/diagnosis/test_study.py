"""The whole diagnosis: effects hidden by the test bed, named by the model, proven on hold-out rows."""

import json
from dataclasses import replace

import numpy as np
import pytest

from bench.separation import beside, standing
from ecm_fast import Mechanism, diagnose, identify, plan, predict, read_measurements
from ecm_fast.cli import main
from ecm_fast.diagnosis.design.detectability import MATERIAL_TESTS
from ecm_fast.diagnosis.design.load_pool import Pool
from ecm_fast.diagnosis.problem.holdout import lock
from ecm_fast.diagnosis.problem.linearization import Linearization
from ecm_fast.diagnosis.search.calibration import calibrate
from ecm_fast.errors import InputError
from ecm_fast.mechanism.catalogue import CATALOGUE
from ecm_fast.mechanism.parameters import find
from ecm_fast.studies.diagnosis import Study
from ecm_fast.testbed import Sensors, equilibria, measure, readings, shear_test, tendon_test
from ecm_fast.testbed.sealed.hide import hide

pytestmark = pytest.mark.slow

NECK = Mechanism()
LOADS = tendon_test(grid=9, seed=2)
MADE = NECK.replace(EA=7600.0, GA=2400.0, EI=2.95)


def declared(data):
    """Return measurements that declare the usual noise of a camera."""
    sigmas = (("sigma_x", 1e-4), ("sigma_z", 1e-4), ("sigma_theta", 1e-3))
    return replace(data, **{name: np.full(data.n, sigma) for name, sigma in sigmas})


@pytest.fixture(scope="module")
def clean():
    return equilibria(MADE, LOADS).raise_if_failed()


@pytest.fixture(scope="module")
def bent():
    return measure(MADE.replace(precurvature=0.12), LOADS, seed=3)


def test_a_hidden_precurvature_is_named_measured_and_proven(bent):
    """Known truth of the test bed: name, size, hold-out error."""
    found = diagnose(NECK, bent)
    assert (found.verdict, found.names) == ("named", ("precurvature",))
    low, high = found.effects[0].interval["precurvature"]
    assert low < 0.12 < high
    assert high - low < 0.006
    assert found.gap.before.sigma > 8.0
    assert 0.8 < found.gap.after.sigma < 1.25
    assert found.gap.closed > 0.99
    assert found.mechanism.effects["precurvature"] == found.effects[0].parameters["precurvature"]
    for name, truth in {"EA": 7600.0, "GA": 2400.0, "EI": 2.95}.items():
        assert abs(found.calibration[name].value - truth) < 4.0 * found.calibration[name].std


def test_clean_data_get_no_name_and_a_table_of_sizes(clean):
    """Binomial: alarms in ten clean sets of the test bed."""
    alarms = [diagnose(NECK, readings(MADE, clean, seed=i), seed=i).verdict != "nothing_found" for i in range(10)]
    assert sum(alarms) <= 1  # 1 % asked: two of ten would come once in 240
    found = diagnose(NECK, readings(MADE, clean, seed=99))
    assert found.effects == ()
    assert {sight.name for sight in found.sights} == set(CATALOGUE)
    seen = {sight.name: sight.smallest for sight in found.sights}
    assert seen["precurvature"] < 0.02


def test_an_effect_as_small_as_promised_is_found():
    """Binomial: the smallest detectable size, hidden twelve times."""
    smallest = next(s.smallest for s in plan(NECK, LOADS).sights if s.name == "clamp_tilt")
    made = equilibria(MADE.replace(clamp_tilt=1.3 * smallest), LOADS)
    count = sum(
        diagnose(NECK, readings(MADE.replace(clamp_tilt=1.3 * smallest), made, seed=i), seed=i).verdict
        != "nothing_found"
        for i in range(12)
    )
    assert count >= 9  # of 12, nine in ten or more: fewer would come once in 40


def test_look_alikes_come_with_every_name():
    """Known truth: constant pulls look alike on these loads."""
    data = measure(MADE.replace(gravity_tilt=0.03), LOADS, seed=4)
    claim = diagnose(NECK, data).effects[0]
    assert "gravity_tilt" in {claim.name, *claim.look_alikes}
    assert claim.look_alikes  # two or more constant pulls differ by less than the noise here


def test_outliers_are_named_by_row_and_do_no_harm(clean):
    """Known truth: the rows that the test bed spoilt."""
    data = readings(MADE, clean, Sensors(outlier_share=0.03), seed=11)
    off = np.abs(data.pose - readings(MADE, clean, seed=11).pose).max(axis=1) > 3e-4
    found = diagnose(NECK, data)
    assert found.verdict == "nothing_found"
    assert {place for place, reason in found.outliers if reason == "outlier"} == {
        data.where(int(i)) for i in np.flatnonzero(off)
    }


def test_what_is_declared_uncertain_is_never_named():
    """Known truth: rotation and offset of the camera."""
    data = measure(MADE, LOADS, Sensors(camera_rotation=0.01, camera_offset=(3e-4, -5e-4, 0.0)), seed=5)
    assert diagnose(NECK, data).verdict != "nothing_found"
    found = diagnose(NECK, data, uncertain={"camera_frame": None})
    assert found.verdict == "nothing_found"
    assert abs(found.calibration["camera_rotation"].value - 0.01) < 4.0 * found.calibration["camera_rotation"].std


def test_material_tests_raise_an_alarm(clean):
    """By hand: a prior far from the known stiffness."""
    data = readings(MADE, clean, seed=6)
    assert not diagnose(NECK, data, priors={"EI": (2.95, 0.01)}).alarms
    assert "EI" in diagnose(NECK, data, priors={"EI": (3.2, 0.01)}, max_effects=0).alarms[0]


def test_a_plan_needs_no_poses_and_mirror_classes_do_not_mix():
    """Mirror symmetry: even and odd signatures are orthogonal."""
    found = plan(NECK, LOADS)
    place = {name: i for i, name in enumerate(found.names)}
    even = [place[name] for name in found.names if CATALOGUE[name].mirror == "even"]
    odd = [place[name] for name in found.names if CATALOGUE[name].mirror == "odd"]
    locked = plan(NECK, tendon_test(grid=3)).cosines  # too few to lock any: the grid is its own mirror image
    assert np.abs(locked[np.ix_(even, odd)]).max() < 1e-5
    assert np.abs(found.cosines).max() < 1.0 + 1e-9
    assert "mooney_rivlin" in found.effects_that_are("invisible")
    assert {"bending_one_sided", "marker_lever_z"} <= set(found.effects_that_are("named"))
    assert "force_gain" in found.effects_that_are("absorbed")


def test_the_distance_to_a_rival_is_what_its_fit_leaves():
    """Another program path: `identify` with the rival."""
    exact = measure(MADE.replace(bending_one_sided=0.003), LOADS, Sensors(camera_sigma=(0.0, 0.0, 0.0)), seed=1)
    noisy = declared(exact)
    found = standing(NECK, noisy, ("bending_one_sided",))
    seen = noisy.select(np.flatnonzero(~lock([noisy], 0)))
    free = ["EA", "GA", "EI"]
    assert found.sigmas == pytest.approx(np.sqrt(identify(NECK, seen, free).chi2), rel=0.01)
    rivals = (found.rival, "plate_misalignment", "pulley_height_asymmetry", "precurvature", "marker_angle_offset")
    left = [np.sqrt(identify(NECK, seen, [*free, CATALOGUE[rival].size.key]).chi2) for rival in rivals]
    assert min(left) == left[0] == pytest.approx(found.apart, rel=0.01)


def test_the_nearest_rival_may_have_unusual_parameters():
    """A camera that lags by four seconds is nearly a neck that forgets all in four seconds, not in the usual minute."""
    exact, _ = hide(effects={"camera_lag": 4.0}, design="T", seed=1, noise="none", spread=False)
    noisy = declared(exact)
    found = standing(NECK, noisy, ("camera_lag",))
    assert (found.sigmas > 15.0, found.rival) == (True, "fading_memory")
    memory = NECK.replace(**{"fading_memory.share": 0.9, "fading_memory.time": 4.0})
    sigmas = predict(memory, noisy).residual[~lock([noisy], 0)] / np.array([1e-4, 1e-4, 1e-3])
    assert found.apart <= np.linalg.norm(sigmas) < 5.0


def test_one_of_two_stands_out_by_what_the_other_leaves():
    """Another program path: `identify` with the other effect."""
    exact = measure(MADE.replace(bending_one_sided=0.003, camera_z_offset=2e-4), LOADS,
                    Sensors(camera_sigma=(0.0, 0.0, 0.0)), seed=1)  # fmt: skip
    noisy = declared(exact)
    found = beside(NECK, noisy, ("bending_one_sided", "camera_z_offset"))
    seen, free = noisy.select(np.flatnonzero(~lock([noisy], 0))), ["EA", "GA", "EI"]
    for name, rest in (("bending_one_sided", "camera_z_offset"), ("camera_z_offset", "bending_one_sided")):
        assert found[name] == pytest.approx(np.sqrt(identify(NECK, seen, [*free, rest]).chi2), rel=0.01)


def test_drift_below_the_noise_shows_no_effect(clean):
    """Three channels drift by one standard deviation of their priors: no statistic exceeds the root of 3."""
    drifting = Sensors(camera_sigma=(0.0, 0.0, 0.0), camera_drift=(3e-5, -3e-5, 3e-4))
    noisy = declared(readings(MADE, clean, drifting, seed=1))
    largest = []
    for share in (0.3, 0.0):
        problem = Study(NECK, noisy).problem()
        problem.drift = share
        values, noise = calibrate(problem)
        largest.append(Linearization.at(problem, values, (), noise, known=True).gates(0.01, 0)[0].statistic)
    assert largest[0] < np.sqrt(3.0) < largest[1]


def test_a_build_within_its_tolerances_shows_no_effect():
    """Two dimensions are off by one standard deviation of their tolerances: no statistic exceeds the root of 2."""
    off = {name: CATALOGUE[name].size.tolerance for name in ("beam_length", "lever_arm_asymmetry")}
    noisy = declared(measure(NECK.replace(**off), LOADS, Sensors(camera_sigma=(0.0, 0.0, 0.0)), seed=1))
    known = {name: (getattr(NECK.beam, name), 1e-3 * getattr(NECK.beam, name)) for name in ("EA", "GA", "EI")}
    largest = []
    for tolerances in (None, {}):
        problem = Study(NECK, noisy, priors=known).problem()
        problem.tolerances = problem.tolerances if tolerances is None else tolerances
        values, noise = calibrate(problem)
        largest.append(Linearization.at(problem, values, (), noise, known=True).gates(0.01, 0)[0].statistic)
    assert largest[0] < np.sqrt(2.0) < largest[1]


def test_many_files_drift_as_one():
    """Counting: columns of drift for one, four and five files."""
    blanks = [replace(declared(LOADS), x=np.full(LOADS.n, 0.1 + 1e-6 * i), z=np.zeros(LOADS.n),
                      theta=np.zeros(LOADS.n)) for i in range(5)]  # fmt: skip
    for files, columns in ((1, 3), (4, 12), (5, 3)):
        problem = Study(NECK, blanks[:files]).problem()
        state = problem.state((), {})
        shift = problem.weights(problem.noise(state), state).shift
        assert shift.shape == (files * LOADS.n, 3, columns)
        assert np.count_nonzero(shift.any(axis=(1, 2))) == files * (LOADS.n - 1)


@pytest.mark.parametrize(("name", "size"), [("camera_lag", 6.0), ("slack", 20.0), ("wall", 2000.0)])
def test_what_is_in_no_catalogue_gets_no_name(name, size):
    """Known truth: an effect outside the catalogue."""
    found = diagnose(NECK, measure(MADE, LOADS, seed=9, hidden={name: size}))
    assert (found.verdict, found.effects) == ("outside_catalogue", ())


def test_an_explanation_that_cannot_be_meant_is_no_answer():
    """Of a lag of the camera by seven seconds the best pair asks for 23 times the typical memory."""
    data, _ = hide(effects={"camera_lag": 7.286}, design="T", seed=1855129820, noise="drift+force")
    found = diagnose(NECK, data)
    assert (found.verdict, found.effects) == ("outside_catalogue", ())
    assert all(np.isfinite(model.behind) for model in found.models)


def test_a_stop_is_found_at_the_angle_where_it_is(clean):
    """Known truth: the angle of the test bed's stop."""
    made = MADE.replace(**{"effects.contact_stop.stiffness": 5.0, "effects.contact_stop.angle": 0.3})
    found = diagnose(NECK, measure(made, LOADS, seed=5))
    assert found.names == ("contact_stop",)
    low, high = found.effects[0].interval["contact_stop.angle"]
    assert low < 0.3 < high < 0.33


def test_a_stop_beside_a_larger_effect_is_found():
    """The usual angle is out of reach, and what the larger effect does hides the stop from the first look."""
    stop = {"effects.contact_stop.stiffness": 4.0, "effects.contact_stop.angle": 0.33}
    found = diagnose(NECK, measure(MADE.replace(bending_one_sided=0.02, **stop), LOADS, seed=3))
    assert found.names == ("bending_one_sided", "contact_stop")
    low, high = found.effects[1].interval["contact_stop.angle"]
    assert low < 0.33 < high < 0.35


def test_a_second_effect_is_named_by_evidence_alone():
    """Known truth: both hidden effects."""
    hidden = {"clamp_lateral_compliance": 5e-6, "force_crosstalk": 0.015}
    data, _ = hide(effects=hidden, design="T+S", noise="force", seed=1)
    found = diagnose(NECK, data, priors={"EA": (7500.0, 75.0), "GA": (2420.0, 17.0), "EI": (3.0, 0.01)})
    assert not any(gate.alarm for gate in found.gates if gate.stage == 1)
    assert found.names == tuple(hidden)
    assert any("clamp_lateral_compliance alone passes the tests, too" in line for line in found.warnings)
    for claim, (name, size) in zip(found.effects, hidden.items(), strict=True):
        low, high = claim.interval[name]
        assert low < size < high


def test_two_laws_without_a_starting_equilibrium_are_found():
    """The first law alone takes on what the second one does; with that on top the neck of the start would buckle."""
    hidden = {"bending_one_sided": 0.0259, "bending_amplitude": -0.0198}
    data, _ = hide(effects=hidden, design="T+S", noise="force", seed=501044113)
    priors = {"EA": (7500.0, 75.0), "GA": (2420.0, 17.0), "EI": (3.0, 0.009)}
    found = diagnose(NECK, data, candidates=["bending_cubic", *hidden], priors=priors)
    assert found.names == tuple(hidden)
    assert found.gap.after.sigma < 1.25


def test_two_rows_that_a_stop_moves_are_no_outliers():
    """Two of the open rows bend further to its side than the angle, which nobody expects there."""
    stop = {"effects.contact_stop_one_sided.stiffness": 8.0, "effects.contact_stop_one_sided.angle": 0.36}
    found = diagnose(NECK, measure(MADE.replace(**stop), LOADS, seed=1))
    assert found.names == ("contact_stop_one_sided",)
    assert not found.rows.outlier.any()


def test_rows_at_a_stop_are_no_outliers_and_the_reverse(clean):
    """Known truth: a stop, and then outliers in the same rows."""
    made = MADE.replace(**{"effects.contact_stop.stiffness": 9.0, "effects.contact_stop.angle": 0.385})
    stopped = measure(made, LOADS, seed=6)
    assert diagnose(NECK, stopped).names == ("contact_stop",)
    read = readings(MADE, clean, seed=6)
    far = np.flatnonzero(np.abs(read.theta) > 0.385)
    off = np.zeros((read.n, 3))
    off[far] = np.random.default_rng(7).choice([-12.0, 12.0], (far.size, 3)) * [1e-4, 1e-4, 1e-3]
    spoiled = replace(read, x=read.x + off[:, 0], z=read.z + off[:, 1], theta=read.theta + off[:, 2])
    found = diagnose(NECK, spoiled)
    assert found.names == ()
    open_rows = np.flatnonzero(~found.rows.locked & found.rows.outlier)
    assert set(open_rows) == set(far[~found.rows.locked[far]])


def column(name, at, step, parts):
    """Return the derivative of all poses in sigmas by central differences."""
    up, down = (np.concatenate([predict(NECK.replace(**{name: at + sign * step}), part).pose for part in parts])
                for sign in (1.0, -1.0))  # fmt: skip
    return ((up - down) / (2.0 * step) / np.array([1e-4, 1e-4, 1e-3])).ravel()


def left_of(effect, parts, scatter=np.inf):
    """Return the sigmas of a typical size beside EA, GA, EI, known to a relative scatter each, and the tolerances."""
    stiffness = {name: getattr(NECK.beam, name) for name in ("EA", "GA", "EI")}
    build = {found.size.key: found.size.tolerance for found in CATALOGUE.values() if found.size.tolerance}
    calibrated = [column(name, value, 1e-3 * value, parts) for name, value in stiffness.items()]
    known = 1.0 / np.array([*(np.asarray(scatter) * list(stiffness.values())), *build.values()])
    fitted = np.column_stack([*calibrated, *(column(name, 0.0, scale, parts) for name, scale in build.items())])
    fitted = np.vstack([fitted, np.diag(known)])
    typical = CATALOGUE[effect].size.typical
    own = column(CATALOGUE[effect].size.key, 0.0, 0.02 * typical, parts)
    own = typical * np.append(own, np.zeros(len(known)))
    return np.linalg.norm(own - fitted @ np.linalg.lstsq(fitted, own, rcond=None)[0])


def test_what_does_not_show_comes_with_loads_that_would():
    """The same plan with those loads added."""
    loads, more = tendon_test(grid=3), Pool.from_add_ons(["wrench"]).data  # a grid of nine has no locked rows
    sights = {sight.name: sight for sight in plan(NECK, loads).sights}
    found = sights["shear_cubic"]
    assert found.visible == "invisible"
    assert found.shown_by.startswith("a wrench")
    assert sights["ogden"].shown_by == ""
    assert sights["ogden"].cure == "nothing that the test bed can do"
    assert found.shown_sigmas == pytest.approx(left_of("shear_cubic", (loads, more)), rel=0.01)


def test_what_calibration_absorbs_comes_with_material_tests():
    """Their scatter is the paper's: 1 %, 0.7 % and 0.3 %."""
    loads = tendon_test(grid=3)
    scatter = [find(name).typical / find(name).default for name in ("EA", "GA", "EI")]
    found = {sight.name: sight for sight in plan(NECK, loads).sights}["bonded_ends"]
    assert found.visible == "absorbed"
    assert found.shown_by == MATERIAL_TESTS
    assert found.shown_sigmas == pytest.approx(left_of("bonded_ends", (loads,), scatter), rel=0.01)
    priors = {name: (getattr(NECK.beam, name), 0.01 * getattr(NECK.beam, name)) for name in ("EA", "GA", "EI")}
    assert all(sight.shown_by != MATERIAL_TESTS for sight in plan(NECK, loads, priors=priors).sights)


def test_the_road_by_command_line(tmp_path, capsys, bent):
    """Known truth, by the commands from diagnose to score."""
    bent.to_csv(tmp_path / "run.csv")
    fresh = measure(MADE.replace(precurvature=0.12), shear_test(np.linspace(-60.0, 60.0, 31)), seed=8)
    fresh.to_csv(tmp_path / "fresh.csv")
    command = ["diagnose", str(tmp_path / "run.csv"), "--test", str(tmp_path / "fresh.csv"), "--out", str(tmp_path)]
    assert main([*command, "--json", "--exit-code"]) == 10
    answer = json.loads(capsys.readouterr().out)
    assert answer["effects"][0]["name"] == "precurvature"
    assert answer["gap"]["after"]["rms_sigma"] < 1.25 < answer["gap"]["before"]["rms_sigma"]
    assert answer["transfer"][0]["rows"] == 31
    written = Mechanism.from_toml(answer["mechanism"])
    rms = predict(written, read_measurements(tmp_path / "fresh.csv")).rms
    assert rms["z_m"] < 1.4e-4
    assert rms["theta_rad"] < 1.4e-3
    assert main(["plan", str(tmp_path / "fresh.csv"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["rows"] == 31


def test_python_gets_what_the_command_line_gets(tmp_path, capsys, bent):
    """The command line's own answer: findings, effects, next loads and the page of a study are the same."""
    pytest.importorskip("matplotlib")
    pytest.importorskip("jinja2")
    bent.to_csv(tmp_path / "run.csv")
    names = ["precurvature", "head_com_sideways", "force_zero_asymmetry"]
    command = ["diagnose", str(tmp_path / "run.csv"), "--candidates", *names, "--out", str(tmp_path)]
    assert main([*command, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    study = Study(Mechanism(), read_measurements(tmp_path / "run.csv"), candidates=names)
    assert list(study.check()) == answer["noticed"]
    found = study.diagnose()
    assert found.to_json_dict()["effects"] == answer["effects"]
    assert study.next_loads(found) is None
    assert answer["next"] == []  # one name stands alone; its nearest rivals are for the command next
    assert main(["next", str(tmp_path), "--minutes", "5", "--json"]) == 0
    further = study.next_loads(found, minutes=5.0, check_single=True)
    assert further.to_json_dict() == json.loads(capsys.readouterr().out)
    page = study.page(found, tmp_path / "python.html")
    assert page.read_text(encoding="utf-8") == (tmp_path / "diagnosis.html").read_text(encoding="utf-8")


def test_what_was_given_is_not_asked_for_again(tmp_path, capsys, clean, monkeypatch):
    """Contract: lines of the answer with and without the noise given."""
    monkeypatch.chdir(tmp_path)
    data = readings(MADE, clean, seed=8)
    replace(data, sigma_lam=np.full(data.n, np.nan)).to_csv("clean.csv")
    asked = ["diagnose", "clean.csv", "--candidates", "beam_mass", "mooney_rivlin"]
    for options, lines in ((["--force-sigma", "0.1"], 0), ([], 1)):
        assert main([*asked, *options]) == 0
        printed = capsys.readouterr()
        assert printed.err.count("no column sigma_lam_N") == lines
        assert printed.out.startswith("nothing_found")
        assert "inf" not in printed.out.split()


def test_hostile_questions_are_answered_in_one_line(bent):
    """Contract: the text of the error."""
    for options, text in (
        ({"candidates": ["precurvatur"]}, "did you mean 'precurvature'"),
        ({"candidates": []}, "give at least one effect"),
        ({"uncertain": {"lever_am": 1e-3}}, "lever_am"),
        ({"uncertain": {"lever_arm": -1e-3}}, "allowed is a number > 0"),
        ({"priors": {"GA": (2400.0, 0.0)}}, "allowed is a finite number > 0"),
        ({"priors": {"length": (0.1, 0.01)}}, "declare it uncertain too"),
        ({"alpha": 0.0}, "alpha = 0.0"),
        ({"max_effects": 5}, "max_effects = 5"),
        ({"force_sigma": -1.0}, "force_sigma"),
    ):
        with pytest.raises(InputError, match=text):
            diagnose(NECK, bent, **options)
    with pytest.raises(InputError, match="at least 3"):
        diagnose(NECK, bent.select([0, 1]))


def test_noise_far_beyond_what_is_declared_is_not_nothing(clean):
    """Counting: readings that scatter three times as declared are no clean data, though no effect looks like that."""
    data = readings(MADE, clean, seed=1)
    sigma = {f"sigma_{name}": getattr(data, f"sigma_{name}") / 3.0 for name in ("x", "z", "theta")}
    answer = diagnose(NECK, replace(data, **sigma))
    assert diagnose(NECK, data).verdict == "nothing_found"
    assert answer.verdict in ("outside_catalogue", "data_gap")
    assert any("times as much as the noise that is declared" in text for text in answer.warnings)


def test_an_unmeasured_channel_counts_for_no_other_loads(clean):
    """By construction: theta is blank, so what theta alone shows has no sigma."""
    data = replace(readings(MADE, clean, seed=4), theta=np.full(LOADS.n, np.nan))
    sights = {sight.name: sight for sight in diagnose(NECK, data).sights}
    whole = {sight.name: sight for sight in plan(NECK, LOADS).sights}
    assert 0.5 * whole["shear_cubic"].shown_sigmas < sights["shear_cubic"].shown_sigmas
    assert sights["marker_angle_offset"].sigmas == 0.0  # theta alone would show it
