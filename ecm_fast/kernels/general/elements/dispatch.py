"""Choice of the element at compile time, by the type of its tables.

So a solve of Lagrange elements knows nothing of the other families, and each family costs its own compilation only.
Every family's module of kernels has the four functions below, with these arguments:

sizes(tables)                                           Gauss points and nodes of an element
element(tables, stations, loads, q, res, K, room)     adds an element's residual and tangent
element_residual(tables, stations, loads, q, res)     adds the residual alone, real or complex
apply_step(tables, q, step, fresh)                            moves the whole beam by Newton's step
"""

from typing import Any

from ....mechanism.mesh.families import Se2Tables, StrainTables
from ..._jit import by_first_type
from . import lagrange, se2, strain

__all__ = ["apply_step", "element", "element_residual", "kernels_for", "sizes"]

MODULES: dict[Any, Any] = {Se2Tables: se2, StrainTables: strain}
"""Kernels by the type of the tables; arrays are those of the Lagrange family."""


def kernels_for(tables: Any) -> Any:
    """Return the module of kernels for tables, or for the type of tables that the compiler sees."""
    return MODULES.get(getattr(tables, "instance_class", type(tables)), lagrange)


sizes: Any = by_first_type(lambda tables: kernels_for(tables).sizes)
element: Any = by_first_type(lambda tables: kernels_for(tables).element)
element_residual: Any = by_first_type(lambda tables: kernels_for(tables).element_residual)
apply_step: Any = by_first_type(lambda tables: kernels_for(tables).apply_step)
