"""The page of measured results, `bench/RESULTS.md`, written whole from the tables in `bench/results.json`.

    python3 tools/run.py python bench/results_page.py

`error_rates.py` and `write_results.py` replace their table and write the page anew; the text around them is in
`bench/results_template.md`.
The sweep rates were measured with `bench_sweeps.py`, their spread over five runs.
"""

import json
from pathlib import Path
from string import Template

from ecm_fast.files import write_whole

FOLDER = Path(__file__).resolve().parent


def page(tables: dict[str, list[str]]) -> str:
    """Return the page with its tables, each given as lines of Markdown."""
    text = Template((FOLDER / "results_template.md").read_text(encoding="utf-8"))
    return text.substitute({name: "\n".join(lines).strip("\n") for name, lines in tables.items()})


def put(name: str, lines: list[str], folder: Path = FOLDER) -> None:
    """Replace one table and write the page anew.

    Parameters
    ----------
    name : ``error_rates`` or ``times``
    lines : the table in Markdown
    folder : where ``results.json`` and ``RESULTS.md`` are
    """
    tables = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    write(tables | {name: lines}, folder)


def write(tables: dict[str, list[str]], folder: Path = FOLDER) -> None:
    """Write the tables and the page."""
    write_whole(folder / "results.json", json.dumps(tables, indent=1, ensure_ascii=False) + "\n")
    write_whole(folder / "RESULTS.md", page(tables))


if __name__ == "__main__":
    write(json.loads((FOLDER / "results.json").read_text(encoding="utf-8")))
