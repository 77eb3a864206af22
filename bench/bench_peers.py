"""One cold solve beside another program's, on the same beam under the same loads; skipped where that is missing.

    python3 tools/run.py pytest bench/bench_peers.py --benchmark-enable

PyElastica (`pip install pyelastica`, group `peers`) has dynamics alone: a rod of fictitious mass is damped until it
rests. It also solves a slightly different rod, whose section keeps its volume, so that its tip ends up elsewhere.
"""

import numpy as np
import pytest

import ecm_fast as ecm

# dead tip force (-50, 40) N and a tip moment of 2 N m that turns x to z; a shooting solution to 1e-12 is the answer
NECK = ecm.Mechanism.preset("slender").replace(length=0.15, EI=3.0, GA=2420.0, EA=7500.0, axial_law="hooke", g=0.0)
WRENCH, TIP = (-50.0, 40.0, -2.0), (0.1458016623, 0.0288482753, -0.2896190646)
MASS, DAMPING, STEPS = 1.0, 300.0, 1400  # [kg/m], [1/s]


def relaxed(n=20):
    """Return the tip (x, z, theta) of PyElastica's rod of n elements, brought to rest from straight."""
    import elastica as ea

    class System(ea.BaseSystemCollection, ea.Constraints, ea.Forcing, ea.Damping):
        pass

    length, radius = 0.15, 2.0 * np.sqrt(3.0 / 7500.0)  # of a round section with this EI / EA
    area = np.pi * radius**2
    x, y, z = np.eye(3)
    rod = ea.CosseratRod.straight_rod(
        n, np.zeros(3), x, y, length, radius, MASS / area,
        youngs_modulus=7500.0 / area, shear_modulus=2420.0 / area * 28.0 / 27.0,
    )  # fmt: skip
    system = System()
    system.append(rod)
    # half the time that a sound wave needs for an element
    dt = 0.5 * length / n / np.sqrt(7500.0 / MASS)
    system.constrain(rod).using(ea.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,))
    force = WRENCH[0] * x + WRENCH[1] * z
    system.add_forcing_to(rod).using(ea.EndpointForces, np.zeros(3), force, ramp_up_time=1e-9)
    system.add_forcing_to(rod).using(_end_couple(ea), WRENCH[2] * y)
    system.dampen(rod).using(ea.AnalyticalLinearDamper, time_step=dt, uniform_damping_constant=DAMPING)
    system.finalize()
    stepper, time = ea.PositionVerlet(), np.float64(0.0)
    for _ in range(STEPS):
        time = stepper.step(system, time, np.float64(dt))
    tangent = rod.tangents[:, -1]
    return rod.position_collection[0, -1], rod.position_collection[2, -1], -np.arctan2(tangent[2], tangent[0])


def _end_couple(ea):
    class EndCouple(ea.NoForces):
        """A dead couple on the last element."""

        def __init__(self, couple):
            super().__init__()
            self.couple = couple

        def apply_torques(self, system, time=0.0):
            system.external_torques[..., -1] += system.director_collection[..., -1] @ self.couple

    return EndCouple


@pytest.mark.parametrize(("elements", "order"), [(1, 5), (20, 1)])
@pytest.mark.benchmark(group="one cold solve of the shared problem")
def bench_ours(benchmark, elements, order):
    model = ecm.FiniteElementModel(NECK, elements, order)
    error, finer = (
        np.abs(ecm.FiniteElementModel(NECK, n, order).solve((0.0, 0.0), WRENCH).pose - TIP).max()
        for n in (elements, 2 * elements)
    )
    assert error < 1e-8 or error / finer == pytest.approx(4.0, rel=0.05)  # linear elements converge with order 2
    benchmark(model.solve, (0.0, 0.0), WRENCH)


@pytest.mark.benchmark(group="one cold solve of the shared problem")
def bench_pyelastica(benchmark):
    pytest.importorskip("elastica", reason="PyElastica is not installed: pip install pyelastica")
    np.testing.assert_allclose(relaxed(), TIP, atol=5e-3)
    benchmark.pedantic(relaxed, rounds=3)
