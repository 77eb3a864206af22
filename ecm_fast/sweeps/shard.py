"""The rows of a chunk as a Parquet file in memory, and what such a file says about itself."""

import json
import threading
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..equilibrium import BatchResult, Status
from ..errors import InputError
from ..parameters import find
from .chunk import Solved
from .spec import LOADS, OUTPUTS, SweepSpec, column

__all__ = ["FAILURES", "encode", "failures", "label", "need_pyarrow"]

FAILURES = 100
"""How many failed cases a chunk lists with their inputs."""
_KEY = b"ecm_fast"
_ROOM = threading.local()


def failures(spec: SweepSpec, number: int, solved: Solved) -> list[dict[str, Any]]:
    """Return the first cases of a chunk that have no stable equilibrium, with their inputs."""
    result = solved.result
    rows = np.flatnonzero(result.status != Status.CONVERGED)[:FAILURES]
    return [
        {
            "case": number * spec.chunk + int(row),
            "status": Status(int(result.status[row])).name.lower(),
            "load_factor": float(result.load_factor[row]),
            **{column(name): float(values[row]) for name, values in solved.inputs.items()},
        }
        for row in rows
    ]


def label(path: Path) -> dict[str, Any] | None:
    """Return what a file of rows says about itself; None where it is no whole file of rows."""
    import pyarrow as pa
    from pyarrow import parquet

    try:
        found: dict[str, Any] = json.loads(parquet.read_schema(path).metadata[_KEY])
    except (OSError, pa.ArrowException, KeyError, TypeError, ValueError):
        return None
    return found


def encode(spec: SweepSpec, number: int, solved: Solved) -> Any:
    """Return the file of a chunk's rows, as a buffer that the calling thread may overwrite with its next one.

    Numbers are stored as they are: to compress random digits costs more than it saves. The same rows give the same
    bytes.
    """
    import pyarrow as pa
    from pyarrow import parquet

    result = solved.result
    about = {
        "sweep": spec.digest,
        "chunk": number,
        "statuses": result.counts(),
        "failures": failures(spec, number, solved),
    }
    schema = _schema(spec).with_metadata({_KEY: json.dumps(about).encode()})
    table = pa.table([*solved.inputs.values(), *_outputs(result)], schema=schema)
    room = _room(table.nbytes + len(schema.metadata[_KEY]) * 2 + 100_000)
    sink = pa.FixedSizeBufferWriter(pa.py_buffer(room))
    with parquet.ParquetWriter(
        sink,
        schema,
        compression="none",
        use_dictionary=["status"],
        write_statistics=["status"],
        data_page_size=1 << 24,
        write_batch_size=1 << 16,
    ) as writer:
        writer.write_table(table, row_group_size=len(result))
    return room.data[: sink.tell()]


def _outputs(result: BatchResult) -> list[NDArray[Any]]:
    return [result.x, result.z, result.theta, result.status.astype(np.int8)]


def _schema(spec: SweepSpec) -> Any:
    import pyarrow as pa

    inputs = [
        pa.field(column(entry.name), pa.float64(), nullable=False, metadata={"unit": _unit(entry.name)})
        for entry in spec.varied
    ]
    outputs = [pa.field(name, pa.float64(), nullable=False) for name in OUTPUTS]
    return pa.schema([*inputs, *outputs, pa.field("status", pa.int8(), nullable=False)])


def _unit(name: str) -> str:
    return {"N": "N", "Nm": "N m"}[LOADS[name][0].rpartition("_")[2]] if name in LOADS else find(name).unit


def _room(size: int) -> NDArray[np.uint8]:
    """Return memory that the calling thread keeps: fresh pages for every chunk would cost as much as the encoding."""
    room: NDArray[np.uint8] | None = getattr(_ROOM, "memory", None)
    if room is None or len(room) < size:
        room = _ROOM.memory = np.empty(size, dtype=np.uint8)
    return room


def need_pyarrow() -> None:
    """Complain, with the cure, where files of rows cannot be written."""
    try:
        import pyarrow  # noqa: F401
    except ImportError:
        raise InputError("rows are kept in Parquet files, which need pyarrow: pip install 'ecm-fast[data]'") from None
