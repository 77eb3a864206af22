"""``ecm-fast predict``: predicted readings for every row of a data file."""

import argparse
from collections.abc import Mapping
from typing import TYPE_CHECKING

from .frame.arguments import add_model, add_noise, discretization, measurements, mechanism
from .frame.command import DONE, IN_OUT, NOT_CONVERGED, Answer, Command, folder, outputs

if TYPE_CHECKING:
    from ..models.instruments.prediction import Prediction

__all__ = ["COMMAND"]

_FAR = 8.0
"""Times its noise beyond which a reading is shown by its row: a diagnosis takes it for an outlier."""
_FIT = 1.5  # times the declared noise up to which nothing needs to be missing
_SHOWN = 5  # lines that fit a screen


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("data", metavar="DATA", help="measurements (.csv, .xlsx, .parquet, .mat); poses may be missing")
    add_model(parser)
    add_noise(parser)


def _run(args: argparse.Namespace) -> Answer:
    from ..models.equilibrium import Status
    from ..models.instruments.prediction import predict

    neck, data = mechanism(args), measurements(args.data, args)
    path = folder(args.out or "out") / "predicted.csv"
    outputs(path)
    prediction = predict(neck, data, **discretization(args))
    prediction.to_csv(path)
    counts, rms = prediction.counts, prediction.rms
    answer = {"rms": rms, "rms_sigma": prediction.rms_sigma, "rows": prediction.rows, "status": counts, "csv": path,
              "warnings": list(prediction.warnings)}  # fmt: skip
    failed = [i for i, status in enumerate(prediction.status) if not Status(status).converged]
    notes = [*(f"warning: {text}" for text in prediction.warnings), f"wrote {path}"]
    if failed:
        first = Status(prediction.status[failed[0]]).explain(prediction.load_factor[failed[0]])
        notes.insert(0, f"{len(failed)} of {data.n} rows did not converge; {data.where(failed[0])}: {first}")
    text = "\n".join([_text(data.n, counts, rms), *_in_noise(prediction), f"next: {_next(prediction)}"])
    return Answer(answer, text, tuple(notes), NOT_CONVERGED if failed else DONE)


def _next(prediction: "Prediction") -> str:
    """Return what to do with a prediction."""
    known = [value for value in prediction.rms_sigma.values() if value is not None]
    if not prediction.rows:
        return "measure poses under these loads and predict them again"
    if known and max(known) < _FIT:
        return "the model holds within the noise here; ecm-fast plan lists what these loads cannot show"
    return "ecm-fast diagnose with the same file says what the model is missing"


def _in_noise(prediction: "Prediction") -> list[str]:
    """Return the same in units of the noise, and the rows that are far beyond it; nothing where none is declared."""
    known = [f"{name} {value:.3g}" for name, value in prediction.rms_sigma.items() if value is not None]
    if not known:
        return []
    import numpy as np

    largest = np.nan_to_num(np.abs(prediction.sigmas)).max(axis=1)
    far = [i for i in np.argsort(-largest).tolist() if largest[i] > _FAR]
    cells = "; that of the force cells comes on top" if np.isfinite(prediction.data.sigma_lam).any() else ""
    lines = [f"in units of the camera's noise as declared: {', '.join(known)}{cells}"]
    lines += [f"far off: {prediction.data.where(i)}, {largest[i]:.0f} times its noise" for i in far[:_SHOWN]]
    return [*lines, f"and {len(far) - _SHOWN} more rows"] if len(far) > _SHOWN else lines


def _text(rows: int, counts: Mapping[str, int], rms: Mapping[str, float | None]) -> str:
    kinds = ", ".join(f"{count} {name}" for name, count in counts.items() if count)
    parts = []
    for column, value in rms.items():
        name, _, unit = column.rpartition("_")
        parts.append(f"{name} {'not measured' if value is None else f'{value:.6g} {unit}'}")
    return f"{rows} rows: {kinds}\nrms of measured less predicted: {', '.join(parts)}"


COMMAND = Command("what the instruments would read for every row of a data file", _add_arguments, _run, IN_OUT)
