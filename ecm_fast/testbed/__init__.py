"""The simulated test bed: measurements of a neck, computed by another method than the model's.

The beam's differential equations are integrated with all rows at once, and instruments read the result. Nothing here
is shared with the finite element model, so a model may be tested on these measurements.

>>> from ecm_fast import Mechanism
>>> from ecm_fast.testbed import Sensors, measure, tendon_test
>>> measure(Mechanism(), tendon_test(5), Sensors(force_sigma=0.1), seed=7).n
5
"""

from .designs import DESIGNS, design
from .equilibria import Equilibria, Outcome, equilibria
from .experiments import compression_test, in_sequence, mass_test, shear_test, tendon_test, tilt_test
from .laws import BUILT_IN
from .outside import OUTSIDE
from .sensors import Sensors, measure, readings
from .variants import VARIANTS

__all__ = [
    "BUILT_IN",
    "DESIGNS",
    "OUTSIDE",
    "VARIANTS",
    "Equilibria",
    "Outcome",
    "Sensors",
    "compression_test",
    "design",
    "equilibria",
    "in_sequence",
    "mass_test",
    "measure",
    "readings",
    "shear_test",
    "tendon_test",
    "tilt_test",
]
