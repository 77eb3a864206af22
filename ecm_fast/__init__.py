"""Statics of a tendon-driven elastic continuum mechanism: the full nonlinear finite element model, fast.

>>> import ecm_fast as ecm
>>> model = ecm.FiniteElementModel(ecm.Mechanism.preset("slender"))
>>> model.solve((40.0, 10.0)).stable
True
"""

# ruff: noqa: F401  `__all__` is made from `_HOME`; the imports below are for type checkers and editors

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .data import Measurements, read_measurements
    from .diagnosis import Diagnosis, Plan, Study, diagnose, plan
    from .discretization import Discretization
    from .effects import CATALOGUE, Effect
    from .element_candidates import Candidate
    from .element_errors import LoadSet
    from .element_study import Choice, ElementStudy, choose_discretization, study_elements
    from .equilibrium import BatchResult, Equilibrium, Status
    from .errors import EcmError, InputError, NotConverged, OutOfRangeWarning, OutOfReach
    from .hiding import hide
    from .identification import identify
    from .identification_result import Estimate, Identification, Profile
    from .material_tests import CompressionFit, fit_compression, fit_shear
    from .mechanism import Beam, Effects, Gravity, Head, Mechanism, Tendons
    from .model import FiniteElementModel
    from .parameters import PARAMETERS, pack, unpack
    from .polynomial import ForwardPolynomial, PolynomialModel
    from .prediction import Prediction, predict
    from .quantity import Quantity
    from .sampling import Posterior, posterior
    from .scoring import Score, score
    from .sweeps import Sweep, SweepSpec, read_spec, sweep
    from .training import TrainingSet, WrenchErrors, relative_errors, tip_wrenches, training_poses, training_rows
    from .truth import Truth
    from .warm import Warmup, warmup

_HOME = {
    "data": ("Measurements", "read_measurements"),
    "diagnosis": ("Diagnosis", "Plan", "Study", "diagnose", "plan"),
    "discretization": ("Discretization",),
    "effects": ("CATALOGUE", "Effect"),
    "user_effects": ("effect", "remove_effect"),
    "element_candidates": ("Candidate",),
    "element_errors": ("LoadSet",),
    "element_study": ("Choice", "ElementStudy", "choose_discretization", "study_elements"),
    "equilibrium": ("BatchResult", "Equilibrium", "Status"),
    "errors": ("EcmError", "InputError", "NotConverged", "OutOfRangeWarning", "OutOfReach"),
    "hiding": ("hide",),
    "identification": ("identify",),
    "identification_result": ("Estimate", "Identification", "Profile"),
    "material_tests": ("CompressionFit", "fit_compression", "fit_shear"),
    "mechanism": ("Beam", "Effects", "Gravity", "Head", "Mechanism", "Tendons"),
    "model": ("FiniteElementModel",),
    "parameters": ("PARAMETERS", "pack", "unpack"),
    "polynomial": ("ForwardPolynomial", "PolynomialModel"),
    "sampling": ("Posterior", "posterior"),
    "prediction": ("Prediction", "predict"),
    "quantity": ("Quantity",),
    "scoring": ("Score", "score"),
    "sweeps": ("Sweep", "SweepSpec", "read_spec", "sweep"),
    "training": (
        "TrainingSet",
        "WrenchErrors",
        "relative_errors",
        "tip_wrenches",
        "training_poses",
        "training_rows",
    ),
    "truth": ("Truth",),
    "warm": ("Warmup", "warmup"),
}
_MODULE = {name: module for module, names in _HOME.items() for name in names}

__version__ = "0.1.0"
__all__ = [*_MODULE, "__version__"]


def __getattr__(name: str) -> Any:
    """Load a public name on first use: the command line's help must not wait for the compiler."""
    if name not in _MODULE:
        raise AttributeError(f"module 'ecm_fast' has no attribute {name!r}")
    return getattr(import_module(f".{_MODULE[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted(__all__)
