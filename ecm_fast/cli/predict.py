"""``ecm-fast predict``: what the instruments would read, for every row of a data file."""

import argparse
from collections.abc import Mapping

from ._answer import DONE, NOT_CONVERGED, Answer, Command, folder
from ._arguments import add_model, discretization, mechanism

__all__ = ["COMMAND"]


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("data", metavar="DATA", help="measurements: .csv, .parquet or .mat; poses may be missing")
    add_model(parser)


def _run(args: argparse.Namespace) -> Answer:
    from ..data import read_measurements
    from ..equilibrium import Status
    from ..prediction import predict

    neck, data = mechanism(args), read_measurements(args.data)
    path = folder(args.out or "out") / "predicted.csv"
    prediction = predict(neck, data, **discretization(args))
    prediction.to_csv(path)
    counts, rms = prediction.counts, prediction.rms
    answer = {"rms": rms, "rows": prediction.rows, "status": counts, "csv": path}
    failed = [i for i, status in enumerate(prediction.status) if not Status(status).converged]
    notes = [f"wrote {path}"]
    if failed:
        first = Status(prediction.status[failed[0]]).explain(prediction.load_factor[failed[0]])
        notes.insert(0, f"{len(failed)} of {data.n} rows did not converge; {data.where(failed[0])}: {first}")
    text = _text(data.n, counts, rms)
    return Answer(answer, text, tuple(notes), NOT_CONVERGED if failed else DONE)


def _text(rows: int, counts: Mapping[str, int], rms: Mapping[str, float | None]) -> str:
    kinds = ", ".join(f"{count} {name}" for name, count in counts.items() if count)
    parts = []
    for column, value in rms.items():
        name, unit = column.split("_")
        parts.append(f"{name} {'not measured' if value is None else f'{value:.6g} {unit}'}")
    return f"{rows} rows: {kinds}\nrms of measured less predicted: {', '.join(parts)}"


COMMAND = Command("what the instruments would read for every row of a data file", _add_arguments, _run)
