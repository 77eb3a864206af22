"""Effects of the catalogue: absent at zero, exactly differentiated, of their mirror class."""

import numpy as np
import pytest

from ecm_fast import CATALOGUE, Discretization, FiniteElementModel, Measurements, Mechanism
from ecm_fast.mechanism.parameters import index
from ecm_fast.mechanism.vector import pack
from ecm_fast.models.instruments.measuring_chain import MeasuringChain

pytestmark = pytest.mark.slow

NECK = Mechanism.preset("slender")
EXACT = 1e-13  # Newton's last step squares it
EFFECTS = [pytest.param(effect, id=effect.name) for effect in CATALOGUE.values()]
OFF_THE_FAST_PATH = {
    "neutral_axis_offset", "bending_cubic", "bending_amplitude", "bending_one_sided", "bimodulus",
    "neo_hookean_section", "mooney_rivlin", "ogden", "shear_cubic", "shear_compression", "clamp_rotation_compliance",
    "clamp_axial_compliance", "clamp_lateral_compliance", "plate_joint_compliance", "contact_stop",
    "contact_stop_one_sided",
}  # fmt: skip
"""Effects with which a section's strains do not follow from its force alone, or whose ends or stops are not plain."""


def record(mirrored=False):
    """Return 24 rows: two sessions, pairs that repeat one load, dead wrenches; or its mirror image."""
    rng = np.random.default_rng(1)
    n = 24
    lam = np.repeat(rng.uniform(5.0, 160.0, (n // 2, 2)), 2, axis=0)
    lam[:4] = [(160.0, 5.0), (160.0, 5.0), (5.0, 160.0), (5.0, 160.0)]
    wrench = np.where(np.arange(n)[:, None] % 3 == 0, rng.normal(size=(n, 3)) * [20.0, 10.0, 1.0], 0.0)
    dwell = rng.uniform(5.0, 120.0, n)
    if mirrored:
        lam, wrench = lam[:, ::-1], wrench * [1.0, -1.0, -1.0]
    return Measurements.from_columns(
        {
            "lam_l_N": lam[:, 0], "lam_r_N": lam[:, 1], "fx_N": wrench[:, 0], "fz_N": wrench[:, 1],
            "tau_Nm": wrench[:, 2], "dwell_s": dwell, "t_s": np.cumsum(dwell + 30.0),
            "pose_id": [str(i // 2) for i in range(n)], "session": ["1"] * (n // 2) + ["2"] * (n // 2),
        }
    )  # fmt: skip


@pytest.fixture(scope="module")
def chains():
    """Return the measuring chain of the record, and that of its mirror image."""
    mesh = Discretization.from_elements(1, 5)
    return MeasuringChain(mesh, record()), MeasuringChain(mesh, record(mirrored=True))


def readings(chain, **changes):
    pose, status, _ = chain.solve(pack(NECK.replace(**changes)), EXACT**2)
    assert (status == 0).all()
    return pose


@pytest.mark.parametrize("effect", EFFECTS)
def test_the_catalogue_says_what_an_effect_is(effect):
    """The entry alone: a size that can be there, a law, and words to explain it."""
    size = effect.size
    assert size.default == 0.0
    assert size.lower <= 0.0 < size.typical <= size.upper
    assert size.name.startswith(effect.name)
    assert effect.law
    assert size.meaning
    assert all(entry.lower <= entry.default <= entry.upper and entry.typical > 0.0 for entry in effect)
    assert set(effect.needs) <= {"t_s", "dwell_s"}


@pytest.mark.parametrize("effect", [p for p in EFFECTS if len(p.values[0].quantities) > 1])
def test_without_its_size_an_effect_is_absent(effect, chains):
    """Bit for bit: places, angles and times mean nothing where the size is zero."""
    others = {entry.key: min(1.5 * entry.default, entry.upper) for entry in effect.quantities[1:]}
    assert np.array_equal(readings(chains[0], **others), readings(chains[0]))


@pytest.mark.parametrize("effect", EFFECTS)
def test_derivatives_are_differences_of_the_readings(effect, chains):
    """Central differences, by every parameter of the effect and by EI beside it, at its typical size.

    A step of a thousandth leaves an error of 1e-6 of the third derivative; friction and memory follow the tip angle,
    which the derivative by EI leaves out on purpose, see `history`.
    """
    present = {entry.key: entry.default for entry in effect} | {effect.size.key: effect.size.typical}
    if effect.name.startswith("contact_stop"):
        present[effect.quantities[1].key] = 0.2
    keys = [*present, "beam.EI"]
    found = chains[0].sensitivities(keys, pack(NECK.replace(**present)), EXACT**2)
    assert np.abs(found.pose - readings(chains[0], **present)).max() < 1e-12
    follows = {"bending_hysteresis", "fading_memory"}
    for k, key in enumerate(keys[:-1] if effect.name in follows else keys):
        value = present.get(key, NECK.beam.EI)
        step = 1e-3 * value
        higher = readings(chains[0], **{**present, key: value + step})
        lower = readings(chains[0], **{**present, key: value - step})
        difference = (higher - lower) / (2.0 * step)
        size = np.abs(difference).max()
        assert size > 0.0
        assert np.abs(found.dpose_dpar[:, :, k] - difference).max() < 3e-6 * size


@pytest.mark.parametrize("effect", EFFECTS)
def test_mirror_class(effect, chains):
    """Symmetry: left and right exchanged, an even effect keeps x and turns z and theta; an odd one changes sign."""
    if effect.mirror not in ("even", "odd"):
        pytest.skip("belongs to neither class")
    sign = 1.0 if effect.mirror == "even" else -1.0
    there = readings(chains[0], **{effect.size.key: effect.size.typical})
    image = readings(chains[1], **{effect.size.key: sign * effect.size.typical})
    assert np.abs(there - image * [1.0, -1.0, -1.0]).max() < 1e-12


@pytest.mark.parametrize("effect", EFFECTS)
def test_which_effects_leave_the_fast_path(effect):
    """The list above: every other effect keeps the control step at its speed."""
    model = FiniteElementModel(NECK.replace(**{effect.size.key: effect.size.typical}))
    assert model.path == ("general" if effect.name in OFF_THE_FAST_PATH else "condensed")


@pytest.mark.parametrize("effect", EFFECTS)
def test_stepper_batch_and_inverse_take_it(effect):
    """The control step and the inverse agree with the solver under every effect."""
    model = FiniteElementModel(NECK.replace(**{effect.size.key: effect.size.typical}), order=5)
    step = model.stepper(derivatives=True)
    for lam in ((60.0, 20.0), (62.0, 19.0)):
        *pose, status = step(*lam)
        path = step.state if effect.enters == "path" else None
        eq = model.solve(lam, path=path)
        assert status == 0
        assert np.abs(np.array(pose) - eq.pose).max() < 1e-10
        assert np.abs(step.jacobian - eq.jacobian).max() < 1e-6 * np.abs(eq.jacobian).max()
    lam = model.inverse(theta=-0.1, co_contraction=50.0, path=path)
    assert model.solve(lam, path=path).theta == pytest.approx(-0.1, abs=1e-9)


def test_every_place_in_the_vector_is_its_own():
    """Counting: no two parameters share a place."""
    places = [index(entry.key) for effect in CATALOGUE.values() for entry in effect]
    assert len(set(places)) == len(places)
