"""Pictures: what is in them, where it lies, and that the same picture is the same file."""

import sys

import numpy as np
import pytest

from ecm_fast.data.measurements import Measurements
from ecm_fast.errors import InputError
from ecm_fast.mechanism.mechanism import Mechanism
from ecm_fast.models.finite_element import FiniteElementModel
from ecm_fast.models.instruments.prediction import predict

pytest.importorskip("matplotlib")

from ecm_fast.pages.page import svg
from ecm_fast.pages.plots import plot_residuals, plot_shape, plot_workspace, random_tendon_forces

RADIUS = 0.0055


@pytest.fixture
def model() -> FiniteElementModel:
    return FiniteElementModel(Mechanism().replace(pulley_radius=RADIUS, pulley_z=0.0645, b=0.01))


def lines(axes):
    """Return the corner points of every line, (n, 2) in x, z [m]."""
    return [1e-3 * np.column_stack([line.get_ydata(), line.get_xdata()]) for line in axes.lines]


def test_a_shape_shows_clamp_pulleys_and_six_lines_a_neck(model) -> None:
    """Counting: lines and circles of the figure."""
    figure = plot_shape(model, [model.solve((160.0, 0.0)), model.solve((0.0, 80.0))])
    (axes,) = figure.axes
    assert len(axes.lines) == 3 + 2 * 6  # clamp and two pulley axles; beam, plate, two tendons, arm and center of mass
    assert [circle.radius for circle in axes.patches] == [1e3 * RADIUS] * 2
    assert [text.get_text() for text in axes.texts] == ["left", "right"]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("z [mm]", "x [mm]")
    assert axes.get_aspect() == 1.0
    left, right = axes.get_xlim()
    assert left == -right > 70.0  # mirror-symmetric, z growing to the left
    (legend,) = figure.legends
    assert len(legend.get_texts()) == 2


def test_a_shape_lies_where_the_neck_is(model) -> None:
    """Geometry by hand from the solved pose."""
    eq = model.solve((160.0, 0.0))
    found = lines(plot_shape(model, eq).axes[0])[3:]
    beam, plate, left, right, arm, mass = found
    np.testing.assert_allclose(beam[0], 0.0, atol=1e-15)
    np.testing.assert_allclose(beam[-1], eq.pose[:2])
    along, across = [np.cos(eq.theta), -np.sin(eq.theta)], [np.sin(eq.theta), np.cos(eq.theta)]
    np.testing.assert_allclose(plate, eq.pose[:2] + np.outer([0.07, -0.07], across))
    np.testing.assert_allclose(mass[0], eq.pose[:2] + 0.05 * np.array(along) + 0.01 * np.array(across))
    np.testing.assert_allclose(arm, [eq.pose[:2], mass[0]])
    for tendon, center, side in ((left, [0.0, 0.0645], 1.0), (right, [0.0, -0.0645], -1.0)):
        spoke = tendon[1] - center
        assert np.hypot(*spoke) == pytest.approx(RADIUS)
        assert spoke @ (tendon[1] - tendon[0]) == pytest.approx(0.0, abs=1e-12)  # tangent to the pulley
        assert side * spoke[1] > 0.0  # on its outer side
        np.testing.assert_allclose(tendon[0], eq.pose[:2] + side * 0.07 * np.array(across))


def test_a_weightless_head_has_no_center_of_mass() -> None:
    """Counting: lines of the figure."""
    model = FiniteElementModel(Mechanism().replace(**{"head.mass": 0.0}))
    assert len(plot_shape(model, model.solve()).axes[0].lines) == 3 + 4


def test_what_is_no_equilibrium_is_not_drawn(model) -> None:
    """Contract: the text of the error."""
    with pytest.raises(InputError, match=r"^equilibrium 1 cannot be drawn: no equilibrium"):
        plot_shape(model, [model.solve(), model.solve((2000.0, 0.0))])


def test_a_workspace_shows_every_pose_twice() -> None:
    """Counting: points of the figure; the range of the forces."""
    figure = plot_workspace(FiniteElementModel(), n=200, rng=7)
    whole, close, bar = figure.axes
    lam = random_tendon_forces(200, 7)
    assert lam.shape == (200, 2)
    assert 0.0 <= lam.min() < 5.0
    assert 155.0 < lam.max() <= 160.0
    pose = FiniteElementModel().solve_batch(lam).pose
    np.testing.assert_allclose(lines(whole)[-1], pose[:, :2])
    (dots,) = close.collections
    np.testing.assert_allclose(dots.get_offsets(), 1e3 * pose[:, [1, 0]])
    np.testing.assert_allclose(dots.get_array(), np.degrees(pose[:, 2]))
    assert whole.get_aspect() == 1.0
    assert whole.get_xlim()[0] == -whole.get_xlim()[1]
    assert close.get_xlim()[0] == -close.get_xlim()[1]
    assert (close.get_xlabel(), close.get_ylabel(), bar.get_ylabel()) == ("z [mm]", "x [mm]", "θ [deg]")


def test_residuals_are_drawn_for_measured_channels_only() -> None:
    """By hand: measured cells."""
    data = Measurements.from_columns(
        {"lam_l_N": [0.0, 50.0, 90.0], "z_mm": [0.0, 7.0, None], "theta_deg": [0.0, -7.5, -13.0]}
    )
    prediction = predict(Mechanism(), data)
    figure = plot_residuals(prediction)
    top_z, top_theta, bottom_z, bottom_theta = figure.axes
    assert (top_z.get_ylabel(), top_theta.get_ylabel()) == ("measured z [mm]", "measured θ [deg]")
    assert (bottom_z.get_xlabel(), bottom_theta.get_xlabel()) == ("predicted z [mm]", "predicted θ [deg]")
    np.testing.assert_allclose(top_z.lines[1].get_ydata(), [0.0, 7.0], atol=1e-12)
    np.testing.assert_allclose(bottom_theta.lines[1].get_ydata(), np.degrees(prediction.residual[:, 2]))


def test_without_a_measured_pose_there_is_nothing_to_draw() -> None:
    """Contract: the text of the error."""
    with pytest.raises(InputError, match="nothing to draw, no row has a measured pose and a prediction"):
        plot_residuals(predict(Mechanism(), Measurements.from_columns({"lam_l_N": [1.0]})))


def test_the_same_picture_is_the_same_text(model) -> None:
    """Contract: the same bytes, no reference outside."""
    for draw in (lambda: plot_shape(model, model.solve((40.0, 10.0))), lambda: plot_workspace(model, 20, 1)):
        first, second = svg(draw(), "name"), svg(draw(), "name")
        assert first == second
        assert first.startswith("<svg ")
        assert first.endswith("</svg>")
        assert "http" not in first
        assert "<metadata" not in first


def test_without_matplotlib_the_error_names_what_to_install(monkeypatch, model) -> None:
    """Contract: the text of the error."""
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(InputError) as caught:
        plot_shape(model, model.solve())
    assert str(caught.value) == "a picture needs matplotlib: pip install 'ecm-fast[plots]'"
