"""The catalogue: physical effects the paper's model leaves out, one file a kind.

An effect is declared here once (name, law, unit, typical size, bounds, mirror class, where it enters) and
takes effect where its law is written: in `kernels.prepare` when it only changes constants of the mechanism,
in `kernels.section` or `kernels.tip` when it changes what happens during a solve. Value 0 means absent.
"""

from . import camera, ends, environment, forces, geometry, path, section
from .effect import Effect, Mirror, also
from .effect import effect as declare
from .forces import FULL_SCALE, LARGEST_PUSH

__all__ = ["CATALOGUE", "FULL_SCALE", "LARGEST_PUSH", "Effect", "Mirror", "also", "declare"]

CATALOGUE: dict[str, Effect] = {
    effect.name: effect
    for group in (section, ends, geometry, forces, environment, camera, path)
    for effect in group.EFFECTS
}
"""Every effect by its name, in the order of the parameter vector."""
