"""The decorators of kernels: compiler flags, and a choice by type while compiling.

Flags
-----
error_model="numpy" : a division by zero gives inf instead of a branch; the branch would stop vectorization.
nogil=True : a thread that solves does not hold up the others.
fastmath : everything that lets the compiler fuse and reorder, but not ``nnan`` and ``ninf``, which would make
    ``isfinite(nan)`` true.
"""

from collections.abc import Callable
from typing import Any

import numba
from llvmlite import binding, ir
from numba.core import cgutils, event, types
from numba.extending import intrinsic, overload, register_jitable

from ._cache import KernelCache
from ._notice import CompileNotice

__all__ = [
    "array_at",
    "by_first_type",
    "call_at",
    "call_kernel",
    "copy",
    "kernel",
    "named_address",
    "ordered_kernel",
    "step_kernel",
    "wide",
]

_notices: Any = event
_notices.register("numba:compile", CompileNotice())
_FASTMATH = {"contract", "nsz", "arcp", "reassoc"}


def kernel(function: Callable[..., Any]) -> Any:
    """Compile `function` on first use, with the flags above, and keep the result in the cache."""
    return _compile(function, _FASTMATH)


def ordered_kernel(function: Callable[..., Any]) -> Any:
    """Compile as `kernel` does, for arithmetic whose order matters to the last digit: terms are only fused."""
    return _compile(function, {"contract"}, forceinline=True)


def step_kernel(function: Callable[..., Any]) -> Any:
    """Compile as `kernel` does, and always inline: what is called inside a loop over cases must not stay a call."""
    return _compile(function, _FASTMATH, forceinline=True)


def call_kernel(function: Callable[..., Any]) -> Any:
    """Compile as `kernel` does, but keep the interpreter's lock: to let go of it costs more than the kernel does."""
    return _compile(function, _FASTMATH, nogil=False)


def by_first_type(choose: Callable[[Any], Any], *, forceinline: bool = False) -> Any:
    """Return a function that is the kernel, or the Python function, which `choose` returns for its first argument.

    While a kernel that calls it is compiled, `choose` is given that argument's type in place of its value: the choice
    costs a call nothing. With `forceinline` it is inlined as a `step_kernel` is.
    """

    def chosen(*arguments: Any) -> Any:
        return choose(arguments[0])(*arguments)

    def written(*types: Any) -> Any:
        function = choose(types[0])
        return getattr(function, "py_func", function)

    register: Any = overload
    register(chosen, jit_options=_options(_FASTMATH, forceinline=forceinline), strict=False)(written)
    return chosen


def _options(fastmath: set[str], *, forceinline: bool = False, nogil: bool = True) -> dict[str, Any]:
    return {"error_model": "numpy", "nogil": nogil, "fastmath": fastmath, "forceinline": forceinline}


def _compile(function: Callable[..., Any], fastmath: set[str], *, forceinline: bool = False, nogil: bool = True) -> Any:
    dispatcher: Any = numba.njit(**_options(fastmath, forceinline=forceinline, nogil=nogil))(function)
    if dispatcher is not function:  # it is where NUMBA_DISABLE_JIT is set
        dispatcher._cache = KernelCache(function)
    return dispatcher


@step_kernel
def copy(source, target):
    """Copy a vector into one that is at least as long.

    `target[:] = source` compiles the words of an error too, two seconds of them for the control step alone.
    """
    for i in range(source.shape[0]):
        target[i] = source[i]


@intrinsic
def _wide(typing_context: Any) -> Any:
    """Let the kernel that calls this use the widest vectors of the machine.

    LLVM keeps to half of them on processors that once lowered their clock for the full width; here the full width
    wins on those too (measured: 1.3 times). The attribute is LLVM's own; llvmlite checks names against a shorter list.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        set.add(builder.function.attributes, '"prefer-vector-width"="512"')
        return context.get_dummy_value()

    return types.none(), generate


wide: Any = _wide  # what it is called with in a kernel is not what it is defined with


@intrinsic
def _pointer_at(typing_context: Any, address: Any) -> Any:
    """Turn an address into a pointer to numbers."""
    pointer: Any = types.CPointer(types.float64)  # type: ignore[no-untyped-call]  # numba is untyped

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], context.get_value_type(pointer))

    return pointer(types.int64), generate


_pointer: Any = _pointer_at
_carray: Any = numba.carray  # type: ignore[attr-defined]  # numba is untyped


@register_jitable
def array_at(address: int, size: int) -> Any:
    """Return the `size` numbers at `address` as an array; the caller answers for both."""
    return _carray(_pointer(address), (size,))


def named_address(name: str, address: int) -> Any:
    """Return a function for kernels that is `address`, whatever it is in the process that runs the kernel.

    The compiled code has the name alone, which is looked up when it is loaded: it can be kept and loaded anywhere.
    """
    binding.add_symbol(name, address)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.ptrtoint(context.get_c_value(builder, ir.IntType(8), name), ir.IntType(64))

    def typed(typing_context: Any) -> Any:
        return types.int64(), generate

    return intrinsic(typed)


_utilities: Any = cgutils


@intrinsic
def _called(typing_context: Any, address: Any, inputs: Any) -> Any:
    """Call the C function at an address with an array of complex numbers; returns the three that it writes."""
    kinds: Any = types
    number, result = kinds.complex128, kinds.UniTuple(kinds.complex128, 3)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        value, count = context.get_value_type(number), len(inputs)
        given = _utilities.alloca_once(builder, ir.ArrayType(value, count))
        found = _utilities.alloca_once(builder, ir.ArrayType(value, 3))
        first, zero = ir.IntType(32)(0), ir.IntType(32)
        for i in range(count):
            entry = builder.extract_value(arguments[1], i)
            builder.store(entry, builder.gep(given, [first, zero(i)]))
        pointer = value.as_pointer()
        function = ir.FunctionType(ir.VoidType(), [pointer, pointer]).as_pointer()
        law = builder.inttoptr(arguments[0], function)
        builder.call(law, [builder.gep(given, [first, first]), builder.gep(found, [first, first])])
        read = [builder.load(builder.gep(found, [first, zero(i)])) for i in range(3)]
        return context.make_tuple(builder, result, read)

    return result(types.int64, inputs), generate


call_at: Any = _called
