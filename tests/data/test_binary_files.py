"""Excel, Parquet and MATLAB files, written by the libraries users write them with; numbers and texts by hand."""

import datetime as dt
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse
from scipy.io import savemat

from ecm_fast.data import unpack
from ecm_fast.data.measurements import Measurements, read_measurements
from ecm_fast.data.unpack import answer
from ecm_fast.errors import InputError


def test_nothing_heavy_is_loaded_before_a_file_needs_it() -> None:
    """Python's own list of loaded modules."""
    heavy = "{'scipy', 'pyarrow', 'pymatreader', 'openpyxl', 'h5py', 'numba', 'pandas'}"
    code = f"import ecm_fast.data.measurements, sys; print(*{heavy} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "\n"


def _refused(path: Path) -> str:
    with pytest.raises(InputError) as caught:
        read_measurements(path)
    return str(caught.value).removeprefix(f"{path}: ")


# A MATLAB user's file: columns and rows as vectors, text as cell and as char array.
def _matlab() -> dict[str, Any]:
    cell = np.empty((3, 1), dtype=object)
    cell[:, 0] = ["tendon", "shear", ""]
    return {
        "lam_l_N": np.array([[40.0], [0.0], [1.0]]),
        "x_mm": np.array([[109.0, np.nan, 98.5]]),
        "experiment": cell,
        "pose_id": np.array(["a", "bc", "d"]),
        "session": np.array([[1.0], [2.0], [2.5]]),
        "note_rig": "cold",
    }


def _check_matlab(run: Measurements) -> None:
    assert run.lam_l.tolist() == [40.0, 0.0, 1.0]
    assert run.x[[0, 2]].tolist() == [0.109, 0.0985]
    assert run.measured[:, 0].tolist() == [True, False, True]
    assert run.experiment.tolist() == ["tendon", "shear", ""]
    assert run.pose_id.tolist() == ["a", "bc", "d"]
    assert run.session.tolist() == ["1", "2", "2.5"]
    assert run.rows.tolist() == [1, 2, 3]
    assert run.counted == "row"


def _save_mat(path: Path, content: dict[str, Any]) -> Path:
    savemat(path, content)
    return path


@pytest.mark.slow
def test_mat_vectors_struct_and_struct_array(tmp_path: Path) -> None:
    """SciPy's savemat, three layouts of the same numbers."""
    vectors = _matlab()
    _check_matlab(read_measurements(_save_mat(tmp_path / "vectors.mat", vectors)))
    _check_matlab(read_measurements(_save_mat(tmp_path / "struct.mat", {"run": vectors, "note": 1.0})))
    savemat(tmp_path / "v7.mat", vectors, do_compression=True)
    _check_matlab(read_measurements(tmp_path / "v7.mat"))
    records = np.array([(40.0, "tendon"), (1.0, "")], dtype=[("lam_l_N", "f8"), ("experiment", "O")])
    run = read_measurements(_save_mat(tmp_path / "records.mat", {"run": records}))
    assert (run.lam_l.tolist(), run.experiment.tolist()) == ([40.0, 1.0], ["tendon", ""])
    one = read_measurements(_save_mat(tmp_path / "one.mat", {"lam_l_N": 3.0, "experiment": "shear"}))
    assert (one.lam_l.tolist(), one.experiment.tolist()) == ([3.0], ["shear"])


@pytest.mark.slow
def test_mat_that_cannot_be(tmp_path: Path) -> None:
    """By hand: the text of the error, for files of SciPy's savemat."""

    def refused(content: dict[str, Any]) -> str:
        return _refused(_save_mat(tmp_path / "run.mat", content))

    allowed = "(allowed is a finite number >= 0)"
    cure = ("save vectors or one struct alone (of a table T: table2struct(T, 'ToScalar', true)), and text as "
            "cellstr")  # fmt: skip
    assert refused({"lam_l_N": [1.0, -2.0]}) == f"row 2, column lam_l_N: -2.0 {allowed}"
    assert refused({"lam_l_N": [1.0, np.inf]}) == f"row 2, column lam_l_N: inf {allowed}"
    assert refused({"lam_l_N": [np.nan]}).startswith("row 1, column lam_l_N: blank (allowed is a finite number >= 0; ")
    assert refused({"lam_l_N": [1.0], "x_m": [1.0, 2.0]}).startswith("lam_l_N has 1 entries, x_m has 2;")
    assert refused({"lam_l_N": np.ones((2, 2))}).startswith("lam_l_N is float64 of shape 2 x 2; allowed is a vector")
    assert refused({"x_m": np.zeros((0, 0))}) == "names columns but holds no rows"
    assert refused({"run": {"x_m": 1.0}, "z_m": 1.0}) == f"run is a struct beside others; {cure}"
    assert refused({"x_m": np.array([1j, 2])}) == f"x_m is complex; {cure}"
    (tmp_path / "text.mat").write_text("lam_l_N\n" + "1\n" * 99)
    assert _refused(tmp_path / "text.mat").startswith("not a readable MATLAB file (")


def test_mat_from_a_big_endian_machine(tmp_path: Path) -> None:
    """By hand: the bytes after MathWorks' description of the format."""

    def element(kind: int, data: bytes) -> bytes:
        return struct.pack(">II", kind, len(data)) + data + bytes(-len(data) % 8)

    double, name = element(9, struct.pack(">2d", 1.5, 2.5)), struct.pack(">HH4s", 4, 1, b"fx_N")
    matrix = element(6, struct.pack(">II", 6, 0)) + element(5, struct.pack(">ii", 2, 1)) + name + double
    (tmp_path / "run.mat").write_bytes(b"MATLAB 5.0".ljust(124) + b"\1\0MI" + element(14, matrix))
    assert read_measurements(tmp_path / "run.mat").fx.tolist() == [1.5, 2.5]


def test_mat_with_a_variable_twice(tmp_path: Path) -> None:
    """By hand: the text of the error, for joined and cut files."""
    path = _save_mat(tmp_path / "run.mat", {"fx_N": [1.0]})
    content = path.read_bytes()
    path.write_bytes(content + content[128:])
    assert _refused(path).startswith('not a readable MATLAB file (Duplicate variable name "fx_N" in stream')
    path.write_bytes(content[:-1])
    assert _refused(path).startswith("not a readable MATLAB file (")


def _write_mat73(path: Path) -> None:
    """Write what MATLAB writes with -v7.3: HDF5 behind 512 bytes of header; arrays lie transposed, text as codes."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w", userblock_size=512) as file:

        def put(name: str, value: Any, kind: bytes) -> Any:
            file[name] = value
            file[name].attrs["MATLAB_class"] = np.bytes_(kind)
            return file[name].ref

        def char(name: str, text: str) -> Any:
            reference = put(name, np.array([[ord(c)] for c in text] or [0, 0], dtype="u2"), b"char")
            if not text:
                file[name].attrs["MATLAB_empty"] = 1
            return reference

        put("lam_l_N", np.array([[40.0, 0.0, 1.0]]), b"double")
        put("x_mm", np.array([[109.0], [np.nan], [98.5]]), b"double")
        cells = [char(f"#refs#/{i}", text) for i, text in enumerate(["tendon", "shear", ""])]
        put("experiment", np.array([cells], dtype=h5py.ref_dtype), b"cell")
        cells = [char(f"#refs#/p{i}", text) for i, text in enumerate(["a", "bc", "d"])]
        put("pose_id", np.array([cells], dtype=h5py.ref_dtype), b"cell")
        put("session", np.array([[1.0, 2.0, 2.5]]), b"double")
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


def test_mat_of_version_73(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """h5py writes the file."""
    pytest.importorskip("pymatreader")
    path = tmp_path / "run.mat"
    _write_mat73(path)
    run = read_measurements(path)
    _check_matlab(run)
    assert run.columns == ("experiment", "lam_l_N", "pose_id", "session", "x_mm")
    whole = path.read_bytes()
    path.write_bytes(whole[:700])
    assert _refused(path).startswith("not a readable MATLAB 7.3 file (")
    monkeypatch.setitem(sys.modules, "pymatreader", None)
    cure = "needs pymatreader: pip install 'ecm-fast[data]'"
    assert answer(".mat", whole, path) == f"reading a MATLAB file of version 7.3 (or save it with -v7) {cure}"


def _save_parquet(path: Path, columns: dict[str, Any]) -> Path:
    pa = pytest.importorskip("pyarrow")
    pq = pytest.importorskip("pyarrow.parquet")
    pq.write_table(pa.table(columns), path)
    return path


def test_parquet(tmp_path: Path) -> None:
    """pyarrow writes the file."""
    columns = {
        "lam_l_N": [40, 0],
        "x_mm": [109.0, None],
        "experiment": ["tendon", None],
        "session": [1.0, 2.5],
        "note": [b"", None],
        "__index_level_0__": [3, 4],
    }
    run = read_measurements(_save_parquet(tmp_path / "run.parquet", columns))
    assert run.lam_l.tolist() == [40.0, 0.0]
    assert run.x[0] == 0.109
    assert run.measured[:, 0].tolist() == [True, False]
    assert run.experiment.tolist() == ["tendon", ""]
    assert run.session.tolist() == ["1", "2.5"]
    assert run.columns == ("lam_l_N", "x_mm", "experiment", "session")
    assert run.where(0) == f"{tmp_path / 'run.parquet'}: row 1"


def test_parquet_that_cannot_be(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By hand: the text of the error, for files of pyarrow."""
    path = _save_parquet(tmp_path / "run.parquet", {"x_mm": [1.0, float("nan")], "fx_N": [None, 1.0]})
    assert _refused(path) == ("2 bad cells: row 1, column fx_N: blank (allowed is a finite number; write 0 for none); "
                              "row 2, column x_mm: nan (allowed is a finite number, or a blank)")  # fmt: skip
    path.write_text("lam_l_N\n1\n")
    assert _refused(path).startswith("not a readable Parquet file (Parquet magic bytes not found in footer.")
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    assert (
        answer(".parquet", path.read_bytes(), path)
        == "reading a Parquet file needs pyarrow: pip install 'ecm-fast[data]'"
    )


@pytest.mark.slow
def test_small_files_that_unpack_to_all_the_memory_are_refused(tmp_path: Path) -> None:
    """Zeros pack well: each of these has a few kilobytes or megabytes and asks for one to a hundred gigabytes."""
    savemat(tmp_path / "v7.mat", {"x_m": np.zeros(30_000_000)}, do_compression=True)
    pa, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    parquet.write_table(pa.table({"x_m": np.zeros(200_000_000)}), tmp_path / "zeros.parquet", compression="zstd")
    labels = pa.DictionaryArray.from_arrays(np.zeros(100_000, dtype=np.int32), ["x" * 1_000_000])
    table = pa.table({"x_m": np.zeros(100_000), "session": labels})
    parquet.write_table(table, tmp_path / "labels.parquet", compression="zstd", store_schema=False)
    names = ["v7.mat", "zeros.parquet", "labels.parquet"]
    if h5py := pytest.importorskip("h5py"):
        with h5py.File(tmp_path / "v73.mat", "w", userblock_size=512) as file:
            own = file.create_dataset("x_m", (1, 3_000_000_000), dtype="f8", chunks=(1, 10_000_000), compression="gzip")
            own.attrs["MATLAB_class"] = np.bytes_("double")
        with (tmp_path / "v73.mat").open("r+b") as stream:
            stream.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")
        names.append("v73.mat")
    for name in names:
        assert (tmp_path / name).stat().st_size < 4e6
        assert _refused(tmp_path / name).startswith("unpacks to ")


@pytest.mark.skipif(sys.platform == "win32", reason="limits of POSIX")
def test_a_limit_that_a_system_refuses_leaves_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    """macOS refuses a bound on addresses below what is mapped."""
    import resource

    bounded = []

    def setrlimit(kind: int, _: tuple[int, int]) -> None:
        if kind == resource.RLIMIT_AS:
            raise ValueError("current limit exceeds maximum limit")
        bounded.append(kind)

    monkeypatch.setattr(resource, "setrlimit", setrlimit)
    unpack._limit()
    assert bounded == [resource.RLIMIT_CPU, resource.RLIMIT_CORE]


def test_a_reader_that_ends_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """POSIX: a process that a signal ends has its number below zero for a code."""
    path = _save_mat(tmp_path / "run.mat", {"x_m": [1.0]})
    monkeypatch.setattr("sys.executable", "/bin/false")
    assert _refused(path) == "not a readable .mat file (its reader ended with code 1)"


def test_objects_of_matlab_are_named(tmp_path: Path) -> None:
    """SciPy writes and reads sparse matrices; what holds no column is said with the cure."""
    path = _save_mat(tmp_path / "run.mat", {"x_m": scipy.sparse.eye(3)})
    assert _refused(path).startswith("x_m is a sparse matrix; save vectors or one struct alone (of a table T: ")


def test_xlsx_that_cannot_be(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By hand: the text of the error, for files of openpyxl."""
    openpyxl = pytest.importorskip("openpyxl")
    book, path = openpyxl.Workbook(), tmp_path / "run.xlsx"
    book.save(path)
    assert _refused(path) == "is empty; the first row names the columns"
    for row in (["lam_l_N", "x_mm", "t_s"], [1.0, "#N/A", dt.datetime(2026, 3, 1, 12)], [2, "#DIV/0!", None]):
        book.active.append(row)
    book.save(path)
    assert _refused(path) == "row 3, column x_mm: '#DIV/0!' (allowed is a finite number, or a blank)"
    book.active["B3"] = 2.5
    book.save(path)
    run = read_measurements(path)
    assert run.lam_l.tolist() == [1.0, 2.0]
    np.testing.assert_array_equal([run.x, run.t], [[np.nan, 0.0025], [0.0, np.nan]])
    assert (run.counted, run.rows.tolist()) == ("row", [2, 3])
    path.write_bytes(path.read_bytes()[:700])
    assert _refused(path).startswith("not a readable Excel file (")
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    assert answer(".xlsx", b"", path) == "reading an Excel file needs openpyxl: pip install 'ecm-fast[data]'"
