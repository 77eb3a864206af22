"""The text of a claim, for claims made by hand."""

import math
from dataclasses import replace

from ecm_fast.diagnosis.answer.sentences import alike, dimensions, meaning, next_best, sentence, size
from ecm_fast.diagnosis.results.external_validation import Transfer
from ecm_fast.diagnosis.results.findings import Claim, HoldoutMisfit, Model, Rms

NAME = "clamp_rotation_compliance"
CLAIM = Claim(NAME, {NAME: 0.00152}, {NAME: (0.00143, 0.00161)}, (), "even", "compliance ratio", 28.3, 1.0)
EXACT = Rms(1e-4, 1e-4, 1e-3, 1.0)


def model(name, behind, refused="", *, in_set=False):
    return Model((name,), (1.0,), 50.0 - behind, 50.0, behind, in_set, refused)


def shown(after, before=18.0, adapted=5.0):
    gaps = (Rms(1e-4, 1e-4, 1e-3, value) for value in (40.0, before, after))
    return Transfer(9, "a/side.csv", *gaps, EXACT, 0.9, 1.32, adapted)


def answer_of(*tests, verdict="named", only=None):
    gap = HoldoutMisfit(20, "rows set aside", Rms(1e-4, 1e-4, 1e-3, 9.0), Rms(1e-4, 1e-4, 1e-3, 2.0), EXACT, EXACT, 1.0)
    return sentence(verdict, (CLAIM,), gap, (), (), None, tests, only)


def test_a_size_has_its_unit_its_interval_and_its_meaning() -> None:
    """By hand: the text."""
    line = size(CLAIM, NAME)
    assert line == "clamp_rotation_compliance = 0.00152 rad/(N m) (90 %: 0.00143 to 0.00161)"
    assert meaning(CLAIM) == "the clamp turns under the beam's couple"
    shorter = replace(CLAIM, name="lever_arm", parameters={"lever_arm": -8e-4})
    assert meaning(shorter).endswith("farther from the middle than drawn; below zero: the other way round")


def test_a_size_far_beyond_what_is_usual_is_said_at_once() -> None:
    """By hand: the first sentence says it from four typical sizes on, and how the law differs."""
    gap = HoldoutMisfit(20, "rows set aside", Rms(1e-4, 1e-4, 1e-3, 9.0), Rms(1e-4, 1e-4, 1e-3, 2.0), EXACT, EXACT, 1.0)
    five, three = (sentence("named", (replace(CLAIM, times=times),), gap, (), (), None) for times in (5.1, 3.0))
    assert "(90 %: 0.00143 to 0.00161), 5 times what is typical, so that it may stand for" in five
    assert "typical" not in three
    bent = sentence("named", (replace(CLAIM, law="its law differs"),), gap, (), (), None)
    assert "0.00161), its law differs; on 20 rows" in bent


def test_look_alikes_have_the_sizes_that_they_would_have() -> None:
    """The best explanation that has a name says its size; a single effect says nothing of a pair."""
    claim = replace(CLAIM, look_alikes=("lever_arm", "soft_spot"), probability=0.62)
    pairs = [
        Model((NAME, "creep"), (1.5e-3, 0.01), 50.0, 50.0, 0.0, in_set=True),
        Model(("lever_arm", "creep"), (-8e-4, 0.01), 47.0, 47.0, 3.0, in_set=True),
        Model(("lever_arm", "shear_cubic"), (-9e-4, 2.0), 46.0, 46.0, 4.0, in_set=True),
        Model(("soft_spot", "creep"), (0.3, 0.01), 30.0, 30.0, 20.0, in_set=False),
        model("lever_arm", 0.0, in_set=True),
    ]
    expected = "lever_arm (-0.0008 m), soft_spot; chance of clamp_rotation_compliance among them 62%"
    assert alike(pairs[::-1], (NAME, "creep"), claim) == expected
    assert alike(pairs, (NAME, "creep"), CLAIM) == ""


def test_the_next_best_is_the_first_plausible_one_outside() -> None:
    """By hand: odds of 28 to 1, and the text."""
    models = [
        model("clamp_rotation_compliance", 0.0, in_set=True),
        model("lever_arm", 2.0, "would have to be negative"),
        model("stiffness_taper", 2.0 * math.log(28.0)),
        model("soft_spot", 40.0),
    ]
    assert next_best(models, ["clamp_rotation_compliance"]) == "next best: stiffness_taper, 28 times less likely"
    assert next_best([models[0], models[3]], ["x"]) == "next best: soft_spot, more than 10000 times less likely"
    assert "can be meant" in next_best(models[:2], ["x"])
    assert next_best(models, []) == ""
    assert next_best(models[:1], ["x"]) == ""  # nothing else was tried


def test_what_fails_comes_first_and_what_holds_comes_last() -> None:
    """By hand: the text."""
    assert answer_of(shown(7.0)).startswith(
        f"{NAME} does NOT carry over to side.csv: 7 times the noise is left (18 without"
    )
    assert "Fit both" in answer_of(shown(7.0))
    assert "within their doubt 5 are left. Fit" in answer_of(shown(7.0))
    assert "within their doubt 1.1 are left: they are not known well enough" in answer_of(shown(7.0, adapted=1.1))
    assert answer_of(shown(1.1)).startswith("The data ask for")
    assert f"{NAME} carries over to side.csv: 1.1 times the noise is left in 9 rows that were" in answer_of(shown(1.1))
    assert answer_of(shown(1.1)).endswith("never fitted (18 without it).")
    others = (("soft_spot", 0.8), ("pulley_radius", 4.4))
    assert answer_of(replace(shown(1.1), rivals=others)).endswith(
        "So does soft_spot (0.8), not refuted by this file. It refutes pulley_radius (4.4)."
    )
    assert "Of the next best, soft_spot (0.8) would. Fit both" in answer_of(replace(shown(7.0), rivals=others))
    assert "None of the next best would: pulley_radius (4.4). Fit both" in answer_of(
        replace(shown(7.0), rivals=others[1:])
    )
    assert "1 more left out as outliers" in answer_of(replace(shown(1.1), left_out=1))
    assert "proves nothing" in answer_of(shown(1.1, before=1.2))
    assert "set aside" in answer_of()
    assert "locked" not in answer_of()


def test_who_allows_few_names_is_told_so() -> None:
    """By hand: the text."""
    assert "may be named" not in answer_of()
    assert answer_of(only=[NAME]).endswith(f"Only {NAME} may be named here: another effect may fit better.")
    assert answer_of(only=["soft_spot"] * 9).endswith(
        "Only 9 effects may be named here: another effect may fit better."
    )
    outside = answer_of(verdict="outside_catalogue", only=["soft_spot"])
    assert outside == ("Something is missing that no one or two effects of those that may be named here (soft_spot) "
                       "explain.")  # fmt: skip


def test_test_files_that_refute_look_alikes_say_which_are_left() -> None:
    """By hand: the text."""
    claim = replace(CLAIM, look_alikes=("lever_arm", "soft_spot"))

    def end(*rivals):
        gap = HoldoutMisfit(20, "rows set aside", EXACT, EXACT, EXACT, EXACT, 1.0)
        test = replace(shown(1.0), rivals=rivals)
        return sentence("family", (claim,), gap, (), (), None, (test,)).rpartition("Of the look-alikes")[2]

    assert end(("lever_arm", 4.2), ("soft_spot", 3.0)) == f" {NAME} alone is left."
    assert end(("lever_arm", 4.2), ("soft_spot", 1.1)) == f" {NAME} and soft_spot are left."
    assert "left." not in end(("creep", 4.2))


def test_dimensions_are_said_where_they_leave_their_tolerances() -> None:
    """Tolerances: 0.03 mm of the beam's length, 0.01 mm of the pulleys' place."""
    fitted = {"beam_length": 1.02e-3, "pulley_shift": -1.27e-4}
    near = "dimensions within their tolerances: 1 of 1; the mechanism file has them as fitted"
    assert dimensions({"beam_length": 2e-5}, {}) == near
    assert dimensions(fitted, {"beam_length": 1e-3}) == (
        f"{near.replace('of 1', 'of 2')}; pulley_shift moves by -0.000127 m, its tolerance is 1e-05"
    )
    assert dimensions({}, {}) == ""
