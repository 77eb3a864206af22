"""The next experiment against brute force: the rival is refitted in full to poses of the true one."""

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

from ecm_fast.data.measurements import Measurements
from ecm_fast.diagnosis.design.load_pool import Pool
from ecm_fast.diagnosis.design.next_loads import Rival, fitted_rivals, in_question, next_loads
from ecm_fast.errors import InputError
from ecm_fast.identification.identify import fit_parameters
from ecm_fast.identification.rows import FitSet
from ecm_fast.mechanism.mechanism import Mechanism
from ecm_fast.models.instruments.prediction import predict
from ecm_fast.testbed import Sensors, measure, tendon_test

pytestmark = pytest.mark.slow

NECK = Mechanism()
FREE = ("EA", "GA", "EI")
SIGMA = (1e-4, 1e-4, 1e-3)
LOADS = tendon_test(12, seed=1)
COLUMNS = {"lam_l_N": "lam_l", "lam_r_N": "lam_r", "fx_N": "fx", "fz_N": "fz", "tau_Nm": "tau",
           "extra_mass_kg": "extra_mass", "tilt_rad": "tilt"}  # fmt: skip


@pytest.fixture(scope="module")
def rivals():
    data = measure(NECK.replace(precurvature=0.05), LOADS, Sensors(), 1)
    return fitted_rivals(NECK, [data], [["precurvature"], ["gravity_tilt"], ["pulley_shift"]])


def without_noise(mechanism, loads):
    """Return the measurements that a mechanism would give, with the noise declared that there is none of."""
    pose = predict(mechanism, loads).pose
    sigma = {f"sigma_{name}": np.full(loads.n, value) for name, value in zip(("x", "z", "theta"), SIGMA, strict=True)}
    columns = dict(zip(("x", "z", "theta"), pose.T.copy(), strict=True))
    return replace(loads, **columns, **sigma, sigma_lam=np.full(loads.n, np.nan))


def with_load(loads, suggestions):
    """Return the loads and those suggested, each as often as it says."""
    table = {name: list(getattr(loads, quantity)) for name, quantity in COLUMNS.items()}
    for entry in suggestions:
        for name, values in table.items():
            values += [entry.loads.get(name, 0.0)] * entry.repeats
    return Measurements.from_columns(table)


def refitted(true, rival, loads):
    """Return the distance that a full fit finds; repeated loads without noise are no copies here."""
    return np.sqrt(fit_parameters([FitSet(rival.mechanism, without_noise(true.mechanism, loads))], rival.free).chi2)


def test_what_is_promised_is_what_a_refit_finds(rivals) -> None:
    """Brute force: the rival refitted in full to poses of the true one."""
    chosen = next_loads(rivals, [LOADS_MEASURED], minutes=4.0)
    assert chosen.suggestions
    for distances, loads in ((chosen.before, LOADS), (chosen.after, with_load(LOADS, chosen.suggestions))):
        for i, true in enumerate(rivals):
            for j, rival in enumerate(rivals):
                if i != j:
                    assert distances[i, j] == pytest.approx(refitted(true, rival, loads), rel=0.1, abs=0.1)


LOADS_MEASURED = without_noise(NECK, LOADS)


def test_a_name_is_checked_against_others_alone(rivals) -> None:
    """The third is the second under another name: no load tells them apart, and none has to."""
    first, second, _ = rivals
    trio = [first, second, Rival(("again",), second.mechanism, second.free)]
    chosen = next_loads(trio, [LOADS_MEASURED], minutes=4.0, first_alone=True)
    assert chosen.suggestions
    assert chosen.twins == ()
    loads = with_load(LOADS, chosen.suggestions)
    apart = [refitted(*pair, loads) for pair in ((first, second), (second, first))]
    assert chosen.worst_after == pytest.approx(min(apart), rel=0.1, abs=0.1)
    assert np.isinf(chosen.before[1, 2])


def test_the_nearest_that_can_be_meant_come_into_question() -> None:
    """By hand: models with their evidence."""

    def model(name, behind, *, in_set=False, refused=""):
        return {"names": [name], "behind": behind, "in_set": in_set, "refused": refused}

    far = [model("e", 30.0), model("b", 6.0), model("c", 7.0), model("d", 8.0), model("f", -1.0, refused="negative")]
    pair = {"names": ["a", "b"], "behind": 0.0, "in_set": False, "refused": ""}
    alone = in_question([model("a", 0.0, in_set=True), *far, pair])
    assert alone == ([("a",), ("b",), ("c",), ("d",)], True)
    alike = in_question([model("a", 0.0, in_set=True), model("b", 2.0, in_set=True), *far])
    assert alike == ([("a",), ("b",)], False)
    assert in_question([]) == ([], False)
    two = {"names": ["a", "b"], "behind": 0.0, "in_set": True, "refused": ""}
    other = {**two, "names": ["a", "c"], "behind": 12.0, "in_set": False}
    assert in_question([two, other, model("a", 0.0, in_set=True)]) == ([("a", "b"), ("a", "c")], True)
    refuted = [{"rivals": [{"name": "b", "carries_over": False}, {"name": "c", "carries_over": True}]}]
    left = in_question([model("a", 0.0, in_set=True), model("b", 2.0, in_set=True), *far], refuted)
    assert left == ([("a",), ("c",), ("d",), ("e",)], True)


def test_the_first_load_is_the_best_of_all_by_brute_force(rivals) -> None:
    """Brute force: every fourth load of the pool, refitted in full."""
    pair, pool = rivals[:2], Pool.from_add_ons(["nothing"])
    chosen = next_loads(pair, [LOADS_MEASURED], minutes=1.5, pool=pool)
    (first,) = chosen.suggestions
    found = []
    for i in range(0, len(pool.loads), 4):
        loads = with_load(LOADS, [replace(first, loads=pool.named(i))])
        found.append(min(refitted(*pair, loads), refitted(*pair[::-1], loads)))
    assert first.promised_sigma >= 0.95 * max(found)
    assert first.promised_sigma > chosen.worst_before
    assert chosen.alone["nothing"] == pytest.approx(first.promised_sigma, rel=0.2)


def test_more_time_never_promises_less(rivals) -> None:
    """Monotony: more time includes every shorter plan."""
    found = [next_loads(rivals, [LOADS_MEASURED], minutes=minutes) for minutes in (1.5, 6.0, 20.0)]
    assert found[0].worst_after <= found[1].worst_after <= found[2].worst_after
    assert all(entry.minutes <= minutes for entry, minutes in zip(found, (1.5, 6.0, 20.0), strict=True))
    promised = [entry.promised_sigma for entry in found[2].suggestions]
    assert promised == sorted(promised)


POOR = tuple(10.0 * sigma for sigma in SIGMA)


def test_every_load_comes_once_and_promises_what_refits_leave(rivals) -> None:
    """Ten times the noise is a tenth of the distance."""
    chosen = next_loads(rivals, [LOADS_MEASURED], minutes=20.0, sigma=POOR)
    assert len({tuple(entry.loads.items()) for entry in chosen.suggestions}) == len(chosen.suggestions)
    assert max(entry.repeats for entry in chosen.suggestions) > 3
    assert chosen.suggestions[-1].promised_sigma == pytest.approx(chosen.worst_after, rel=1e-6)
    for count in range(1, len(chosen.suggestions) + 1):
        loads = with_load(LOADS, chosen.suggestions[:count])
        apart = [0.1 * refitted(one, other, loads) for one, other in permutations(rivals, 2)]
        assert chosen.suggestions[count - 1].promised_sigma == pytest.approx(min(apart), rel=0.1, abs=0.1)


def test_time_that_will_not_do_still_gets_a_plan(rivals) -> None:
    """By hand: the text; and the time it asks for does suffice."""
    chosen = next_loads(rivals, [LOADS_MEASURED], minutes=1.5, sigma=POOR)
    assert len(chosen.suggestions) == 1
    assert 0.0 < chosen.worst_before < chosen.worst_after < 3.0
    assert all(0.0 < sigma < 3.0 for sigma in chosen.alone.values())
    assert chosen.notes == ("1.5 minutes bring no two of them 3 sigma apart; 24 would",)
    assert next_loads(rivals, [LOADS_MEASURED], minutes=24.0, sigma=POOR).worst_after > 3.0


def test_force_noise_costs_certainty(rivals) -> None:
    """Monotony: more noise, less distance."""
    sharp, blunt = (next_loads(rivals, [LOADS_MEASURED], force_sigma=force, minutes=6.0) for force in (0.0, 0.5))
    assert blunt.worst_before < sharp.worst_before


def test_material_tests_keep_rivals_apart(rivals) -> None:
    """Least squares: what a rival must also keep to adds to its distance, by every load."""
    priors = {"EA": (NECK.beam.EA, 75.0), "GA": (NECK.beam.GA, 17.0), "EI": (NECK.beam.EI, 0.009)}
    free, held = (next_loads(rivals, [LOADS_MEASURED], priors=own, minutes=4.0) for own in (None, priors))
    apart = ~np.eye(len(rivals), dtype=bool)
    assert (held.before[apart] > free.before[apart] - 1e-6).all()
    assert held.worst_before > free.worst_before


def test_a_mass_splits_what_tendons_cannot() -> None:
    """A center of mass off the middle and a precurvature act alike until the mass changes (a known look-alike)."""
    tilted = Rival(("gravity_tilt",), NECK.replace(gravity_tilt=0.1), (*FREE, "gravity_tilt"))
    curved = fitted_rivals(NECK, [without_noise(tilted.mechanism, LOADS)], [["precurvature"]])[0]
    chosen = next_loads([tilted, curved], [LOADS_MEASURED], minutes=30.0)
    assert chosen.alone["mass"] > chosen.alone["nothing"]


def test_what_cannot_be_told_apart_by_any_load_is_said() -> None:
    """By construction: the same model under two names."""
    twins = [Rival((name,), NECK, FREE) for name in ("one", "other")]
    chosen = next_loads(twins, [LOADS_MEASURED])
    assert chosen.suggestions == ()
    assert "no load that fits into the time tells them apart" in repr(chosen)
    assert chosen.to_json_dict()["sigma_after"] == 0.0


def test_explanations_that_are_far_apart_need_no_load(rivals) -> None:
    """By construction: noise a hundred times smaller."""
    chosen = next_loads(rivals, [LOADS_MEASURED], sigma=(1e-6, 1e-6, 1e-5))
    assert chosen.suggestions == ()
    assert chosen.worst_before > 8.0
    assert "these are told apart already" in repr(chosen)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"minutes": -1.0}, "minutes = -1"),
        ({"repeats": 0}, "repeats = 0"),
        ({"sigma": (1e-4, 1e-4)}, "three positive"),
    ],
)
def test_bad_numbers_are_told(rivals, options, message) -> None:
    """Contract: the text of the error."""
    with pytest.raises(InputError, match=message):
        next_loads(rivals, [LOADS_MEASURED], **options)


def test_one_explanation_needs_no_experiment(rivals) -> None:
    """Contract: the text of the error."""
    with pytest.raises(InputError, match="nothing to tell apart"):
        next_loads(rivals[:1], [LOADS_MEASURED])
    with pytest.raises(InputError, match=r"add-on 'masss'.*did you mean 'mass'"):
        Pool.from_add_ons(["masss"])


def test_no_load_is_larger_than_what_can_be_applied(rivals) -> None:
    """By hand: the loads left in the pool."""
    pool = Pool.from_add_ons(["wrench"]).within({"fx_N": 0.0, "tau_Nm": 0.0, "fz_N": 50.0})
    assert sorted(pool.loads[:, 3]) == [-33.0, 33.0]
    assert np.count_nonzero(pool.loads) == 2
    assert pool.add_on == ("wrench", "wrench")
    found = next_loads(rivals[:2], [LOADS_MEASURED], pool=Pool.from_add_ons().within({"fx_N": 0.0, "lam_l_N": 80.0}))
    assert all("fx_N" not in entry.loads and entry.loads["lam_l_N"] <= 80.0 for entry in found.suggestions)
    for limits, message in (
        ({"fy_N": 1.0}, "limit of 'fy_N': allowed are lam_l_N, lam_r_N, fx_N"),
        ({"fz_N": -1.0}, "limit of fz_N = -1.0: allowed is a number >= 0"),
        ({"fx_N": 0.0, "fz_N": 0.0, "tau_Nm": 0.0}, "leave no load"),
    ):
        with pytest.raises(InputError, match=message):
            Pool.from_add_ons(["wrench"]).within(limits)
