"""Statics of a tendon-driven elastic continuum mechanism: the full nonlinear finite element model, fast.

>>> import ecm_fast as ecm
>>> model = ecm.FiniteElementModel(ecm.Mechanism.preset("slender"))
>>> model.solve((40.0, 10.0)).stable
True
"""

from importlib import import_module

TYPE_CHECKING = False  # as in `typing`, which a command would load before it can see to an interrupt
if TYPE_CHECKING:  # for type checkers and editors; at run time `__getattr__` imports
    from .data import datasets
    from .data.measurements import Measurements, read_measurements
    from .diagnosis import Diagnosis, Plan
    from .errors import EcmError, InputError, NotConverged, OutOfRangeWarning, OutOfReach
    from .identification.identify import identify
    from .identification.material_tests import CompressionFit, fit_compression, fit_shear
    from .identification.posterior import Posterior, posterior
    from .identification.result import Estimate, Identification, Profile
    from .mechanism.catalogue import CATALOGUE, Effect, also
    from .mechanism.mechanism import Effects, Mechanism
    from .mechanism.mesh.discretization import Discretization
    from .mechanism.parameters import PARAMETERS
    from .mechanism.quantity import Quantity
    from .mechanism.sections import Beam, Gravity, Head, Tendons
    from .mechanism.vector import pack, unpack
    from .models.equilibrium import BatchResult, Equilibrium, Status
    from .models.finite_element import FiniteElementModel
    from .models.instruments.prediction import Prediction, predict
    from .models.path_state import PathState
    from .models.polynomial.model import ForwardPolynomial, PolynomialModel
    from .models.polynomial.training import (
        TrainingSet,
        WrenchErrors,
        relative_errors,
        tip_wrenches,
        training_poses,
        training_rows,
    )
    from .models.stepper import Stepper
    from .models.user_effects import effect, load_effects, remove_effect
    from .studies.diagnosis import Study, diagnose, plan
    from .studies.elements.candidates import Candidate
    from .studies.elements.errors import LoadSet
    from .studies.elements.study import Choice, ElementStudy, choose_discretization, study_elements
    from .studies.sweeps import Sweep, SweepSpec, read_spec, sweep
    from .studies.warmup import Warmup, warmup
    from .testbed.sealed.ground_truth import Truth
    from .testbed.sealed.hide import hide
    from .testbed.sealed.score import Score, score

_HOME = {
    "data.measurements": ("Measurements", "read_measurements"),
    "diagnosis": ("Diagnosis", "Plan"),
    "studies.diagnosis": ("Study", "diagnose", "plan"),
    "mechanism.mesh.discretization": ("Discretization",),
    "mechanism.catalogue": ("CATALOGUE", "Effect", "also"),
    "models.user_effects": ("effect", "load_effects", "remove_effect"),
    "studies.elements.candidates": ("Candidate",),
    "studies.elements.errors": ("LoadSet",),
    "studies.elements.study": ("Choice", "ElementStudy", "choose_discretization", "study_elements"),
    "models.equilibrium": ("BatchResult", "Equilibrium", "Status"),
    "errors": ("EcmError", "InputError", "NotConverged", "OutOfRangeWarning", "OutOfReach"),
    "testbed.sealed.hide": ("hide",),
    "identification.identify": ("identify",),
    "identification.result": ("Estimate", "Identification", "Profile"),
    "identification.material_tests": ("CompressionFit", "fit_compression", "fit_shear"),
    "mechanism.mechanism": ("Effects", "Mechanism"),
    "models.finite_element": ("FiniteElementModel",),
    "models.path_state": ("PathState",),
    "models.stepper": ("Stepper",),
    "mechanism.parameters": ("PARAMETERS",),
    "mechanism.sections": ("Beam", "Gravity", "Head", "Tendons"),
    "mechanism.vector": ("pack", "unpack"),
    "models.polynomial.model": ("ForwardPolynomial", "PolynomialModel"),
    "identification.posterior": ("Posterior", "posterior"),
    "models.instruments.prediction": ("Prediction", "predict"),
    "mechanism.quantity": ("Quantity",),
    "testbed.sealed.score": ("Score", "score"),
    "studies.sweeps": ("Sweep", "SweepSpec", "read_spec", "sweep"),
    "models.polynomial.training": (
        "TrainingSet",
        "WrenchErrors",
        "relative_errors",
        "tip_wrenches",
        "training_poses",
        "training_rows",
    ),
    "testbed.sealed.ground_truth": ("Truth",),
    "studies.warmup": ("Warmup", "warmup"),
}
_MODULE = {name: module for module, names in _HOME.items() for name in names}
_FOLDER = {"datasets": "data.datasets"}

__version__ = "0.1.0"
# written out, because type checkers run nothing: what is not listed here they take for private
__all__ = [
    "CATALOGUE",
    "PARAMETERS",
    "BatchResult",
    "Beam",
    "Candidate",
    "Choice",
    "CompressionFit",
    "Diagnosis",
    "Discretization",
    "EcmError",
    "Effect",
    "Effects",
    "ElementStudy",
    "Equilibrium",
    "Estimate",
    "FiniteElementModel",
    "ForwardPolynomial",
    "Gravity",
    "Head",
    "Identification",
    "InputError",
    "LoadSet",
    "Measurements",
    "Mechanism",
    "NotConverged",
    "OutOfRangeWarning",
    "OutOfReach",
    "PathState",
    "Plan",
    "PolynomialModel",
    "Posterior",
    "Prediction",
    "Profile",
    "Quantity",
    "Score",
    "Status",
    "Stepper",
    "Study",
    "Sweep",
    "SweepSpec",
    "Tendons",
    "TrainingSet",
    "Truth",
    "Warmup",
    "WrenchErrors",
    "__version__",
    "also",
    "choose_discretization",
    "datasets",
    "diagnose",
    "effect",
    "fit_compression",
    "fit_shear",
    "hide",
    "identify",
    "load_effects",
    "pack",
    "plan",
    "posterior",
    "predict",
    "read_measurements",
    "read_spec",
    "relative_errors",
    "remove_effect",
    "score",
    "study_elements",
    "sweep",
    "tip_wrenches",
    "training_poses",
    "training_rows",
    "unpack",
    "warmup",
]


if not TYPE_CHECKING:  # a type checker would take any name for public

    def __getattr__(name: str) -> object:
        """Load a public name on first use: the command line's help must not wait for the compiler."""
        if name in _FOLDER:
            return import_module(f".{_FOLDER[name]}", __name__)
        if name not in _MODULE:
            raise AttributeError(f"module 'ecm_fast' has no attribute {name!r}")
        return getattr(import_module(f".{_MODULE[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted(__all__)
