"""The figure of the README: what a diagnosis leaves of the misfit, before and after.

    python3 tools/run.py python tools/draw_gap.py

It hides an effect, diagnoses the measurements, prints the answer and keeps one figure of its page.
"""

from pathlib import Path

import ecm_fast as ecm
from ecm_fast.pages.diagnosis.maps import residual_maps
from ecm_fast.pages.diagnosis.rows import Story
from ecm_fast.pages.plots import picture_bytes

TARGET = Path(__file__).resolve().parent.parent / ".pictures" / "gap.svg"


def main() -> None:
    """Write the figure."""
    neck = ecm.Mechanism.preset("slender")
    data, _ = ecm.hide(effects={"bending_cubic": None}, design="T+S", noise="force", seed=0)
    answer = ecm.diagnose(neck, data)
    print(answer)
    picture = residual_maps(Story(answer, neck))
    assert picture is not None
    TARGET.write_bytes(picture_bytes(picture.figure, "svg"))


if __name__ == "__main__":
    main()
