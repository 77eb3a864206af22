"""The rows of a chunk as a Parquet file with its metadata."""

import functools
import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...mechanism.parameters import find
from ...models.equilibrium import Status
from .chunk import Solved
from .spec import LOADS, OUTPUTS, Input, SweepSpec, column

__all__ = ["FAILURES", "checksum", "encode", "failures", "label", "need_pyarrow"]

FAILURES = 100
"""Most failed cases that a chunk lists with their inputs."""
_KEY = b"ecm_fast"


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


def encode(spec: SweepSpec, number: int, solved: Solved) -> tuple[dict[str, int], memoryview]:
    """Return counts by status and the file of a chunk's rows; the same rows give the same bytes.

    Numbers are stored as they are: to compress random digits, or to look for the extremes of a page, costs more than
    it saves.
    """
    import pyarrow as pa
    from pyarrow import parquet

    result, statuses = solved.result, solved.result.counts()
    failed = failures(spec, number, solved) if statuses["converged"] < len(result) else []
    about = {"sweep": spec.digest, "chunk": number, "statuses": statuses, "failures": failed}
    schema = _schema(spec.varied).with_metadata({_KEY: json.dumps(about).encode()})
    columns = [*solved.inputs.values(), result.x, result.z, result.theta, result.status.astype(np.int8)]
    sink = pa.BufferOutputStream()
    table = pa.table([pa.array(values) for values in columns], schema=schema)
    parquet.write_table(table, sink, compression="none", use_dictionary=["status"], write_statistics=False)
    return statuses, memoryview(sink.getvalue())


def checksum(content: bytes | memoryview) -> str:
    """Return the checksum of a file, as the program ``sha256sum`` writes it."""
    return hashlib.sha256(content).hexdigest()


@functools.lru_cache(maxsize=8)
def _schema(varied: tuple[Input, ...]) -> Any:
    """Return Arrow's types of the columns, with their units."""
    import pyarrow as pa

    inputs = [
        pa.field(column(entry.name), pa.float64(), nullable=False, metadata={"unit": _unit(entry.name)})
        for entry in varied
    ]
    outputs = [pa.field(name, pa.float64(), nullable=False) for name in OUTPUTS]
    return pa.schema([*inputs, *outputs, pa.field("status", pa.int8(), nullable=False)])


def _unit(name: str) -> str:
    return {"N": "N", "Nm": "N m"}[LOADS[name][0].rpartition("_")[2]] if name in LOADS else find(name).unit


def need_pyarrow() -> None:
    """Complain, with the cure, where files of rows cannot be written."""
    try:
        import pyarrow  # noqa: F401
    except ImportError:
        raise InputError("rows are kept in Parquet files, which need pyarrow: pip install 'ecm-fast[data]'") from None
