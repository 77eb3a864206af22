"""Per-thread scratch buffers: fresh memory for every chunk costs a third of the solve time."""

import math
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from ...models.finite_element import FiniteElementModel

__all__ = ["ScratchBuffers", "own_room"]

_OWN = threading.local()


class ScratchBuffers:
    """Arrays by name, made when first asked for; and the model of a sweep, of which each thread needs its own."""

    def __init__(self) -> None:
        self._memory: dict[str, NDArray[np.uint8]] = {}
        self._model: tuple[str, FiniteElementModel] | None = None

    def array(self, name: str, *shape: int, dtype: DTypeLike = np.float64) -> NDArray[Any]:
        """Return an array of any content, in the place of what this name stood for before."""
        size = math.prod(shape) * np.dtype(dtype).itemsize
        memory = self._memory.get(name)
        if memory is None or len(memory) < size:
            memory = self._memory[name] = np.empty(size, dtype=np.uint8)
        return memory[:size].view(dtype).reshape(shape)

    def model(self, sweep: str, make: Callable[[], FiniteElementModel]) -> FiniteElementModel:
        """Return the model of a sweep, made when it is another sweep than before."""
        if self._model is None or self._model[0] != sweep:
            self._model = sweep, make()
        return self._model[1]

    def __repr__(self) -> str:
        return f"Room({', '.join(self._memory)}; {sum(map(len, self._memory.values()))} bytes)"


def own_room() -> ScratchBuffers:
    """Return the calling thread's own."""
    room: ScratchBuffers | None = getattr(_OWN, "room", None)
    if room is None:
        room = _OWN.room = ScratchBuffers()
    return room
