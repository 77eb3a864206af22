"""Hostile files: whatever the bytes, the answer is finite loads or one line of `InputError`."""

import functools
import io
import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ecm_fast.data import readers
from ecm_fast.data.columns import COLUMNS
from ecm_fast.data.grid import Layout, RawTable, table
from ecm_fast.data.measurements import read_measurements
from ecm_fast.data.unpack import READERS, answer
from ecm_fast.errors import InputError

pytestmark = pytest.mark.slow

NAMES = [name for column in COLUMNS.values() for name in column.names]

ODD = ["", " ", "1,5", "nan", "-0", "1e400", "1_0", '"', '"1"', "'", "#", "\ufeff", "\x0b", "\u2028", "\r"]

numbers = st.one_of(st.integers(0, 9).map(str), st.floats(0, 1e300).map(repr))
odd_cells = st.one_of(st.floats().map(repr), st.sampled_from(ODD), st.text(max_size=5))
cells = st.integers(0, 9).flatmap(lambda one_in_ten: odd_cells if one_in_ten == 9 else numbers)
names = st.sampled_from([*NAMES * 4, *COLUMNS, "note", "x_inch"])


@st.composite
def sheets(draw: st.DrawFn) -> bytes:
    """Draw files that nearly are what they should be."""
    delimiter, ending = draw(st.sampled_from([",", ";", "\t"])), draw(st.sampled_from(["\n", "\r\n", "\r"]))
    header = draw(st.lists(names, min_size=1, max_size=4, unique=True))
    width = draw(st.sampled_from([len(header)] * 9 + [2]))
    rows = draw(st.lists(st.lists(cells, min_size=width, max_size=width), min_size=1, max_size=3))
    return ending.join(delimiter.join(row) for row in [header, *rows]).encode("utf-8", "surrogatepass")


def damaged(whole: bytes) -> st.SearchStrategy[bytes]:
    """Draw `whole` with some bytes overwritten and the end cut off."""
    changes = st.dictionaries(st.integers(0, len(whole) - 1), st.integers(0, 255), max_size=6)

    def damage(change: dict[int, int], end: int) -> bytes:
        content = bytearray(whole)
        for place, byte in change.items():
            content[place] = byte
        return bytes(content[:end])

    return st.builds(damage, changes, st.one_of(st.just(len(whole)), st.integers(0, len(whole))))


@pytest.fixture(scope="module", autouse=True)
def one_process() -> Iterator[None]:
    """Read binary files in one process that stays: to start one for each takes half a second."""

    def unpacked(content: bytes, path: Path, layout: Layout, bare: bool) -> RawTable:
        try:
            found = pools[-1].submit(answer, path.suffix, content, path, layout.sheet, bare).result()
        except BrokenProcessPool:  # what a damaged file can do to SciPy's reader
            pools.append(ProcessPoolExecutor(1, mp_context=get_context("spawn")))
            raise InputError("not a readable file (its reader ended)") from None
        if isinstance(found, str):
            raise InputError(found)
        return table(found, "row", layout, bare=bare) if isinstance(found, list) else found

    pools = [ProcessPoolExecutor(1, mp_context=get_context("spawn"))]
    with pytest.MonkeyPatch.context() as patch:
        for ending in READERS:
            patch.setitem(readers._READERS, ending, unpacked)
        yield
    for pool in pools:
        pool.shutdown()


def check(content: bytes, ending: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"run{ending}"
        path.write_bytes(content)
        try:
            run = read_measurements(path)
        except InputError as error:
            text = str(error)
            assert text.startswith(f"{path}: ")
            assert len(text.splitlines()) == 1
            return
    loads = np.column_stack([run.lam, run.wrench, run.extra_mass, run.tilt])
    assert loads.shape == (run.n, 7)
    assert run.n > 0
    assert np.isfinite(loads).all()
    assert (run.lam >= 0).all()
    assert not np.isinf(run.pose).any()


@settings(max_examples=400, deadline=None, derandomize=True)
@given(sheets())
def test_near_sheets(content: bytes) -> None:
    """Contract: finite loads or one line of error, for random tables."""
    check(content, ".csv")


@settings(max_examples=200, deadline=None, derandomize=True)
@given(st.one_of(st.text().map(lambda text: text.encode("utf-8", "surrogatepass")), st.binary()))
def test_any_bytes_as_csv(content: bytes) -> None:
    """Contract: finite loads or one line of error, for random bytes."""
    check(content, ".csv")


@settings(max_examples=100, deadline=None, derandomize=True)
@given(st.binary(), st.sampled_from([".mat", ".parquet", ".xlsx"]))
def test_any_bytes_as_a_binary_file(content: bytes, ending: str) -> None:
    """Contract: finite loads or one line of error, for random bytes."""
    if ending == ".parquet":
        pytest.importorskip("pyarrow.parquet")
    if ending == ".xlsx":
        pytest.importorskip("openpyxl")
    check(content, ending)


def _mat() -> bytes:
    from scipy.io import savemat

    stream = io.BytesIO()
    savemat(stream, {"lam_l_N": [1.0, 2.0], "x_mm": [3.0, np.nan], "session": np.array(["a", "b"], dtype=object)})
    return stream.getvalue()


def _parquet() -> bytes:
    pa = pytest.importorskip("pyarrow")
    pq = pytest.importorskip("pyarrow.parquet")
    stream = io.BytesIO()
    pq.write_table(pa.table({"lam_l_N": [1.0, 2.0], "x_mm": [3.0, None], "session": ["a", "b"]}), stream)
    return stream.getvalue()


@settings(max_examples=200, deadline=None, derandomize=True)
@given(st.data())
def test_damaged_mat(data: st.DataObject) -> None:
    """Contract: finite loads or one line of error, for good files with changed bytes."""
    check(data.draw(damaged(_mat())), ".mat")


@settings(max_examples=200, deadline=None, derandomize=True)
@given(st.data())
def test_damaged_parquet(data: st.DataObject) -> None:
    """Contract: finite loads or one line of error, for good files with changed bytes."""
    check(data.draw(damaged(_parquet())), ".parquet")


@functools.cache  # a workbook holds the time at which it was saved
def _xlsx() -> bytes:
    openpyxl = pytest.importorskip("openpyxl")
    stream, book = io.BytesIO(), openpyxl.Workbook()
    for row in (["lam_l_N", "x_mm", "session"], [1.0, 3.0, "a"], [2.0, None, "b"]):
        book.active.append(row)
    book.save(stream)
    return stream.getvalue()


@settings(max_examples=200, deadline=None, derandomize=True)
@given(st.data())
def test_damaged_xlsx(data: st.DataObject) -> None:
    """Contract: finite loads or one line of error, for good files with changed bytes."""
    check(data.draw(damaged(_xlsx())), ".xlsx")
