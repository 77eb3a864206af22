"""The two tests of the paper's Section 2.4, as Table 1 reports them: compression (43), (44) and shear (45)."""

from dataclasses import dataclass
from typing import Any

from ..data.measurements import Measurements
from ..mechanism.mechanism import Mechanism
from .identify import identify
from .result import Identification

__all__ = ["CompressionFit", "fit_compression", "fit_shear"]


@dataclass(frozen=True, eq=False)
class CompressionFit:
    """The axial stiffness of one specimen by both axial laws, a row of Table 1, left.

    Attributes
    ----------
    neo_hookean, hooke : the fits of EA; their rms says which law meets the readings better
    """

    neo_hookean: Identification
    hooke: Identification

    @property
    def ratio(self) -> float:
        """EA by Hooke's law over EA by the neo-Hookean one."""
        return self.hooke["EA"].value / self.neo_hookean["EA"].value

    def __repr__(self) -> str:
        parts = [f"{law} EA {fit['EA']}, rms x {fit.rms['x_m']:.3g} m" for law, fit in self._fits]
        return f"<CompressionFit: {'; '.join(parts)}; ratio {self.ratio:.4f}>"

    @property
    def _fits(self) -> tuple[tuple[str, Identification], ...]:
        return ("neo-hookean", self.neo_hookean), ("hooke", self.hooke)


def fit_compression(specimen: Mechanism, data: Measurements, **options: Any) -> CompressionFit:
    """Return EA from the positions x of a specimen under axial forces, (43) and (44), by both axial laws.

    Parameters
    ----------
    specimen : what was compressed, e.g. without a head; its EA is the start
    data : forces fx, negative for a push, and positions x
    options : of `identify`
    """
    laws = (specimen.replace(axial_law=law) for law in ("neo-hookean", "hooke"))
    return CompressionFit(*(identify(law, data, ["EA"], **{"channels": ("x",), **options}) for law in laws))


def fit_shear(neck: Mechanism, data: Measurements, **options: Any) -> Identification:
    """Return GA and EI from z and theta under side forces fz, (45): a row of Table 1, right.

    Parameters
    ----------
    neck : what was bent, with the EA of the compression test; its GA and EI are the start
    data : forces fz and poses; z and theta count
    options : of `identify`
    """
    return identify(neck, data, ["GA", "EI"], **{"channels": ("z", "theta"), **options})
