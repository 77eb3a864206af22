"""Mutants: a small change of the code each (cosmic-ray's operators), and whether a test notices it. By hand, not in CI.

    python3 tools/run.py python -m uv pip install cosmic-ray
    COVERAGE_FILE=found.lines python3 tools/run.py python -m coverage run --rcfile=bench/robustness/mutants.cfg \
        -m pytest -m "not slow" tests/data tests/diagnosis tests/identification tests/models
    python3 tools/run.py python bench/robustness/mutants.py found.jsonl found.lines kernels models diagnosis data

The sample is seeded, and drawn anew from the code that there is. Each mutant is made in a copy of the tree. A mutant of
Python code meets the tests that run its line, those that run least beside it first; one of a kernel meets the tests of
its folder, with every kernel compiled anew and LLVM's optimization off. A survivor is a line of `found.jsonl` whose
outcome is "survived" ("late": no test failed within the limit): look at its change, which may mean nothing. A test
that is red without a mutant kills all that meet it: see first that none is.

At commit 9720c8c 103 of the 200 were run, 1 of them in the kernels: 75 killed, 22 survived, 6 not decided, since the
test that failed was red now and then without them. Tests notice 7 of the survivors by now, and the code of one is gone.
Of the others two in the checks of instruments may matter (`calibration` line 154, `force_cells` line 47); the rest
change a message, a cost or a bound that is arbitrary, or nothing.
"""

import difflib
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

from cosmic_ray.ast import get_ast
from cosmic_ray.mutating import MutationVisitor
from cosmic_ray.plugins import get_operator, operator_names
from coverage import CoverageData

ROOT = Path(__file__).parents[2]
# of each group: folders, and how many mutants of them
GROUPS = {
    "kernels": (("kernels",), 40),
    "models": (("models",), 40),
    "diagnosis": (("diagnosis", "identification"), 70),
    "data": (("data",), 50),
}
# what has no tests by design: the oracle is checked by what it checks, the compiler's plumbing by everything
LEFT_OUT = ("models/reference/", "kernels/_", "kernels/layout")
# tests by the beginning of a path, the first that fits: of kernels, whose lines no tracer sees, and of what slow tests
# alone check
SUITES = {
    "diagnosis": [f"tests/diagnosis/test_{name}.py" for name in ("statistics", "build", "study")],
    "identification": ["tests/identification"],
    "models/instruments/checks": ["tests/models/test_checks.py"],
    "kernels/chain": ["tests/kernels/test_chain.py"],
    "kernels/condensed/step": ["tests/models/test_stepper.py", "tests/kernels/test_condensed.py"],
    "kernels/condensed": ["tests/kernels/test_condensed.py"],
    "kernels/unroll": ["tests/kernels/test_unroll.py", "tests/kernels/test_condensed.py"],
    "kernels/general/elements": ["tests/mechanism/test_families.py"],
    "kernels/general/sensitivity": ["tests/models/test_sensitivity.py"],
    "kernels/general/lengths": ["tests/models/robot/test_tendons.py"],
    "kernels/general/tendon": ["tests/models/robot/test_tendons.py"],
    "kernels/history": ["tests/models/test_path_step.py", "tests/models/test_predict.py"],
    "kernels/polynomial": ["tests/models/test_polynomial.py"],
    "kernels/user_laws": ["tests/models/test_user_effects.py"],
    "kernels/body": ["tests/models/test_reference.py", "tests/mechanism"],
    "kernels/camera": ["tests/models/test_predict.py", "tests/models/test_reference.py"],
    "kernels": [
        "tests/models/test_reference.py",
        "tests/models/test_solver.py",
        "tests/models/test_batch.py",
        "tests/kernels/test_condensed.py",
    ],
}
# operators that leave Python and numba something to run: others are noticed by the first call
OPERATORS = ("Add_Sub", "Sub_Add", "Mul_Div", "Div_Mul", "Pow_Mul", "Lt_LtE", "Lt_Gt", "LtE_Lt", "LtE_GtE", "Gt_GtE",
             "Gt_Lt", "GtE_Gt", "GtE_LtE", "Eq_NotEq", "NotEq_Eq", "USub_UAdd", "Delete_Not", "core/NumberReplacer",
             "AddNot", "True", "False", "AndWithOr", "OrWithAnd", "Break", "Continue", "ZeroIteration")  # fmt: skip
LIMIT, MOST_TESTS = 400, 30


def mutants(folders: tuple[str, ...], count: int) -> list[tuple[Path, str, int]]:
    """Return a seeded sample of mutants: file, operator, and which of its places."""
    found = []
    names = sorted(name for name in operator_names() if any(part in name for part in OPERATORS))
    files = [path for folder in folders for path in sorted((ROOT / "ecm_fast" / folder).rglob("*.py"))]
    for path in files:
        if any(part in str(path.relative_to(ROOT)) for part in LEFT_OUT):
            continue
        for name in names:
            places = MutationVisitor(-1, get_operator(name)())
            places.walk(get_ast(path.read_text()))
            found += [(path, name, k) for k in range(places._count)]
    return random.Random(0).sample(found, count)


def main(out: Path, lines: Path, groups: list[str]) -> None:
    """Make the mutants of some groups, run the tests, and write a line for each."""
    data = CoverageData(str(lines))
    data.read()
    sizes: dict[str, int] = defaultdict(int)
    for file in data.measured_files():
        for contexts in data.contexts_by_lineno(file).values():
            for name in contexts:
                sizes[name] += 1
    done = {tuple(json.loads(line)["mutant"]) for line in out.read_text().splitlines()} if out.exists() else set()
    with tempfile.TemporaryDirectory() as name:
        copy = Path(name) / "tree"
        shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns(".*", "__pycache__"))
        sample = [mutant for group in groups for mutant in mutants(*GROUPS[group])]
        for path, operator, place in random.Random(0).sample(sample, len(sample)):
            inside = path.relative_to(ROOT)
            if (str(inside), operator, place) in done:
                continue
            before = (copy / inside).read_text()
            after = MutationVisitor.mutate_code(before, get_operator(operator)(), place)
            change = list(difflib.unified_diff(before.splitlines(), after.splitlines(), n=0, lineterm=""))[2:]
            line = int(change[0].split()[1].split(",")[0][1:])
            tests = _tests(str(inside), data.contexts_by_lineno(str(path)).get(line, []), sizes)
            (copy / inside).write_text(after)
            outcome = _run(copy, tests, "kernels" in inside.parts)
            (copy / inside).write_text(before)
            record = {"mutant": (str(inside), operator, place), "line": line, "change": change[1:], **outcome}
            with out.open("a") as log:
                log.write(json.dumps(record) + "\n")
            print(outcome["outcome"], inside, line, *change[1:], sep="\n   ", flush=True)


def _tests(inside: str, contexts: list[str], sizes: dict[str, int]) -> list[str]:
    """Return the tests of a line as words for pytest; slow ones only in a suite that is no kernel's."""
    suites = [tests for start, tests in SUITES.items() if inside.startswith(f"ecm_fast/{start}")]
    if suites and "/kernels/" not in inside:
        return suites[0]
    named = sorted({name for name in contexts if ".test_" in name}, key=sizes.__getitem__)[:MOST_TESTS]
    cut = [name.rsplit(".", 1) for name in named]
    found = [f"{module.replace('.', '/')}.py::{function}" for module, function in cut]
    return ["-m", "not slow", *(suites[0] if suites else found or [f"tests/{inside.split('/')[1]}"])]


def _run(copy: Path, tests: list[str], compiled: bool) -> dict[str, object]:
    with tempfile.TemporaryDirectory() as cache:
        env = {**os.environ, "PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}
        if compiled:
            env |= {"NUMBA_CACHE_DIR": cache, "NUMBA_OPT": "0"}
        words = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *tests]
        process = subprocess.Popen(words, cwd=copy, env=env, stdout=subprocess.PIPE, stderr=-2, text=True)
        try:
            text = process.communicate(timeout=LIMIT)[0]
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            return {"outcome": "late", "tests": tests}
    by = [row for row in text.splitlines() if row.startswith(("FAILED", "ERROR"))][:1]
    return {"outcome": "survived" if process.returncode in (0, 5) else "killed", "by": by, "tests": tests}


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3:])
