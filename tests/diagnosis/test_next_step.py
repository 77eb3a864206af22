"""The next step after an answer: by hand, for every verdict, with and without a gap that stays."""

from typing import get_args

import pytest

from ecm_fast.diagnosis.answer.next_step import next_step, unexplained
from ecm_fast.diagnosis.results.findings import Verdict

CLOSED = {"after": {"rms_sigma": 1.07, "interval": [0.89, 1.25]}}
OPEN = {"after": {"rms_sigma": 2.5, "interval": [2.1, 2.9]}}


@pytest.mark.parametrize("verdict", get_args(Verdict))
def test_every_verdict_has_a_next_step(verdict: str) -> None:
    """Contract: a sentence for each, without and with rows set aside."""
    for gap in ({"rows": 0}, CLOSED, OPEN, {"after": {"rms_sigma": None, "interval": [None, None]}}):
        assert len(next_step(verdict, gap, ["dwell_s"])) > 20
    assert ("dwell_s" in next_step(verdict, CLOSED, ["dwell_s"])) == (verdict == "data_gap")


def test_a_gap_that_stays_is_said() -> None:
    """By hand: an interval that lies above the noise."""
    assert unexplained(OPEN) == 2.5
    assert unexplained(CLOSED) == unexplained({"rows": 0}) == 0.0
    assert next_step("named", OPEN).startswith("2.5 times the noise is left on rows set aside, so more is missing: ")
    assert next_step("nothing_found", OPEN) != next_step("nothing_found", CLOSED)
