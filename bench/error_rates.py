"""Measure how often a diagnosis is right: hide effects, diagnose, score, and write the rates.

    python3 tools/run.py python bench/error_rates.py --folder sealed [--count 20] [--seed 0] [--jobs 2]

Sets lie in the folder, one file of measurements, one of the truth and one of the answer each. What is there is not made
again, so that a run can be stopped and taken up, and answers alone can be thrown away (`--forget`) when the diagnosis
has changed. On clean data every noise is a cell of its own; the other sets take the noises in turn. Every set is
answered twice: told what material tests say of EA, GA and EI, as the paper's do, and told nothing but the file.
"""

import argparse
import json
import math
import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import ecm_fast as ecm
from bench import results_page
from bench.separation import beside, standing
from ecm_fast.data.measurements import Measurements, read_measurements
from ecm_fast.diagnosis.problem.holdout import lock
from ecm_fast.errors import InputError
from ecm_fast.files import write_whole
from ecm_fast.mechanism.catalogue import CATALOGUE
from ecm_fast.mechanism.parameters import find
from ecm_fast.testbed import BUILT_IN, OUTSIDE, VARIANTS
from ecm_fast.testbed.sealed.ground_truth import Truth
from ecm_fast.testbed.sealed.hide import conditions, hide
from ecm_fast.testbed.sealed.score import Score, score

DESIGNS = {
    "T": "81 tip poses (T)",
    "T+S": "and nine side forces (T+S)",
    "T+S+C+M+W": "and pushes, couples, 2 kg more (T+S+C+M+W)",
}
MATERIALS = {
    "known": "EA, GA and EI known from material tests, to 1 %, 0.7 % and 0.3 %:",
    "unknown": "Nothing known of EA, GA and EI but their order of magnitude:",
}
NOISES = (
    "white",
    "force",
    "strong_force",
    "tails+force",
    "correlated+force",
    "outliers+force",
    "drift+force",
    "undeclared+force",
    "geometry+force",
    "tails+correlated+outliers+drift+geometry+force",
)
GROUPS = ("clean", "effects", "variants", "pairs", "outside")
SETS_OF_A_PAIR_CELL = 10
"""Pairs are drawn at random from a cell of their own, this many times as many as of one effect."""
Told = dict[str, tuple[float, float]]
"""Material tests given to a diagnosis beside the file: values and standard deviations by name."""
Diagnose = Callable[[Path, Told], dict[str, Any]]
Tell = Callable[[Path, Truth, dict[str, Any], Told], dict[str, Any]]
BUILD = ("geometry", "frame", "undeclared")
"""Noises that say what is built and done; the others are those of the instruments."""
SEEN, LEFT = 4.0, 8.0
"""Sigmas from which on an effect of another law is asked for, and what the catalogue's law may leave of a near one."""
LITTLE, MUCH = "8 sigma or less", "more than 8 sigma"
INVISIBLE, VISIBLE = 2.0, 3.0
"""Sigmas below which nobody could see an effect, and from which a gap shows on the locked rows alone."""


class Cell(NamedTuple):
    """Sets of one kind; without a noise they take all in turn."""

    group: str
    name: str
    design: str
    noise: str
    count: int


class Sealed(NamedTuple):
    """One set, to be found again by its place and seed."""

    cell: Cell
    number: int
    folder: Path
    run: int = 0
    materials: str = "known"

    @property
    def answer(self) -> Path:
        """The file of its answer."""
        return Path(f"{self.stem}.{self.materials}.answer.json")

    @property
    def priors(self) -> Told:
        """The material tests that its diagnosis is given: the test bed draws the stiffnesses with the same scatter."""
        return material_tests() if self.materials == "known" else {}

    @property
    def stem(self) -> str:
        """The path of its files, without their endings."""
        cell = self.cell
        return str(self.folder / cell.group / cell.design / f"{cell.name}-{self.number:04d}")

    def noise(self, noises: tuple[str, ...]) -> str:
        """Return how it is read."""
        return self.cell.noise or noises[self.number % len(noises)]

    @property
    def seed(self) -> int:
        """Different for every set, the same on every machine."""
        run = f"{self.run}/" if self.run else ""
        return zlib.crc32(f"{run}{self.cell.group}/{self.cell.design}/{self.cell.name}/{self.number}".encode())


def material_tests() -> Told:
    """Return what tests of the material would say of the neck: its values, and their scatter in the paper."""
    beam = ecm.Mechanism().beam
    return {name: (getattr(beam, name), find(name).typical) for name in ("EA", "GA", "EI")}


def cells(groups: Iterable[str], designs: Iterable[str], noises: tuple[str, ...], count: int) -> Iterator[Cell]:
    """Yield every cell asked for."""
    for design in designs:
        for group in groups:
            if group == "clean":
                yield from (Cell(group, noise, design, noise, count) for noise in noises)
            elif group == "variants":
                yield from (
                    Cell(group, f"{name}~{variant}", design, "", count)
                    for variant, law in VARIANTS.items()
                    for name in law.effects
                )
            elif group == "pairs":
                yield Cell(group, "pair", design, "", SETS_OF_A_PAIR_CELL * count)
            else:
                names = [name for name in CATALOGUE if name in BUILT_IN] if group == "effects" else [*OUTSIDE]
                yield from (Cell(group, name, design, "", count) for name in names)


def hidden(sealed: Sealed) -> dict[str, None]:
    """Return what a set hides, with sizes to be drawn."""
    if sealed.cell.group == "clean":
        return {}
    if sealed.cell.group == "pairs":
        known = sorted(BUILT_IN)
        return dict.fromkeys(np.random.default_rng(sealed.seed).choice(known, 2, replace=False).tolist())
    return {sealed.cell.name.partition("~")[0]: None}


def generate(sealed: Sealed, noises: tuple[str, ...]) -> bool:
    """Write a set unless it is there; the truth is written last, so that it vouches for the rest."""
    truth_file, stem = Path(f"{sealed.stem}.truth.json"), sealed.stem
    if truth_file.exists():
        return True
    truth_file.parent.mkdir(parents=True, exist_ok=True)
    noise, design = sealed.noise(noises), sealed.cell.design
    try:
        data, truth = hide(
            effects=hidden(sealed),
            design=design,
            seed=sealed.seed,
            noise=noise,
            variant=sealed.cell.name.partition("~")[2],
        )
    except InputError as error:  # a row has no equilibrium
        write_whole(f"{stem}.failed.txt", f"{error}\n")
        return False
    data.to_csv(f"{stem}.csv", "SIMULATED, nobody measured this.")
    truth.to_json(truth_file)
    return True


def diagnosed(path: Path, priors: Told, candidates: Sequence[str] | None = None) -> dict[str, Any]:
    """Return the answer of the package about a file of measurements."""
    found = ecm.diagnose(ecm.Mechanism(), read_measurements(path), priors=priors, candidates=candidates)
    answer: dict[str, Any] = found.to_json_dict()
    return answer


def told(path: Path, truth: Truth, answer: dict[str, Any], priors: Told) -> dict[str, Any]:
    """Return what only the truth can tell: how far each hidden effect stands out, and how much of the gap is closed."""
    if truth.kind == "clean":
        return {}
    neck, read, hidden = ecm.Mechanism(), read_measurements(path), {**truth.effects, **truth.outside}
    names, exact, stands = (*truth.names, *truth.outside), still(truth, hidden), {}
    if len(names) == 1:
        stands[names[0]] = asdict(standing(neck, exact, names, priors=priors))
    else:  # what one of two would show alone
        for name in names:
            own = {key: value for key, value in hidden.items() if key.partition(".")[0] == name}
            stands[name] = asdict(standing(neck, still(truth, own), names, rivals=0, priors=priors))
        for name, sigmas in beside(neck, exact, names, priors=priors).items():
            stands[name]["beside"] = sigmas
    found: dict[str, Any] = {"stands": stands, **closed(exact, read, answer)}
    if truth.variant:
        keys = [entry.name for name in truth.names for entry in CATALOGUE[name]]
        found["left"] = math.sqrt(ecm.identify(neck, exact, ["EA", "GA", "EI", *keys], priors=priors or None).chi2)
    if found["closed"] is not None and len(names) == 1 and not truth.outside:
        own = closed(exact, read, diagnosed(path, priors, names))
        found |= {"most": own["closed"], "most_since_given": own["closed_since_given"]}
    return found


def still(truth: Truth, effects: dict[str, float]) -> Measurements:
    """Return the poses without noise under the loads without noise, and the noise that readings have, said or not."""
    noise = "+".join([*(name for name in truth.noise.split("+") if name in BUILD), "none"])
    data, _ = hide(effects=effects, design=truth.design, seed=truth.seed, noise=noise, variant=truth.variant)
    sensors = conditions(truth.noise).sensors
    sigmas = (*sensors.camera_sigma, sensors.force_sigma)
    names = ("sigma_x", "sigma_z", "sigma_theta", "sigma_lam")
    return replace(data, **{name: np.full(data.n, sigma) for name, sigma in zip(names, sigmas, strict=True)})


def closed(exact: Measurements, read: Measurements, answer: dict[str, Any]) -> dict[str, float | None]:
    """Return the gap on the locked rows' poses without noise [sigma], and the share of its square that is closed.

    The gap is that of all these rows together, of the mechanism calibrated alone; the share, and that of the gap of the
    mechanism as given, are None where the answer names nothing.
    """
    given, rows = ecm.Mechanism(), lock([read], 0)
    effects = {f"effects.{name}": value for entry in answer["effects"] for name, value in entry["parameters"].items()}
    before, after = (
        {name: entry["value"] for name, entry in answer[f"calibration{when}"].items()} | answer[f"dimensions{when}"]
        for when in ("_before", "")
    )
    sigma = np.column_stack([exact.sigma_x, exact.sigma_z, exact.sigma_theta])
    first, second, last = (
        float(np.nansum((ecm.predict(neck, exact).residual / sigma)[rows] ** 2))
        for neck in (given, given.replace(**before), given.replace(**after, **effects))
    )
    shares = [1.0 - last / gap if answer["effects"] else None for gap in (second, first)]
    return {"gap": math.sqrt(second), "closed": shares[0], "closed_since_given": shares[1]}


def work(sealed: Sealed, noises: tuple[str, ...], diagnose: Diagnose | None, tell: Tell) -> bool:
    """Make a set and its answer, where either is missing; False where there is none."""
    if not generate(sealed, noises):
        return False
    data, priors = Path(f"{sealed.stem}.csv"), sealed.priors
    if diagnose is not None and not sealed.answer.exists():
        found = diagnose(data, priors)
        found["told"] = tell(data, Truth.from_json(f"{sealed.stem}.truth.json"), found, priors)
        write_whole(sealed.answer, json.dumps(found) + "\n")
    return True


class Graded(NamedTuple):
    """A set's cell, the grade of its answer, what only the truth can tell, and what the answer says of the hidden.

    chance : that it gives its first explanation among all of as many effects, None where it names none
    """

    cell: Cell
    grade: Score
    told: dict[str, Any]
    said: dict[str, Any]
    chance: float | None

    def least(self, what: str) -> float:
        """Return the smallest of the hidden effects' sigmas, or of their distances to rivals."""
        return min((entry[what] for entry in self.told.get("stands", {}).values()), default=0.0)

    @property
    def unseen(self) -> bool | None:
        """Whether the answer says that an effect this small does not show, and names none; None where it could."""
        if self.least("sigmas") >= INVISIBLE:
            return None
        size = self.said.get("smallest")
        return not self.grade.named and (size is None or size > self.said["size"])

    @property
    def cured(self) -> bool | None:
        """Whether it says what would show it where a typical size would not, either; None where one would."""
        hides = self.unseen and self.said["visible"] in ("absorbed", "invisible")
        return bool(self.said["needs"] or self.said["shown_by"]) if hides else None


def graded(sets: Iterable[Sealed]) -> list[Graded]:
    """Return the grades of all answers that are there."""
    found = []
    for sealed in sets:
        if sealed.answer.exists():
            truth = Truth.from_json(f"{sealed.stem}.truth.json")
            words = json.loads(sealed.answer.read_text(encoding="utf-8"))
            said = next((sight for sight in words.get("sights", ()) if truth.names == (sight["name"],)), {})
            if said:
                said["size"] = abs(truth.effects[CATALOGUE[said["name"]].size.name])
            found.append(Graded(sealed.cell, score(words, truth), words.get("told", {}), said, chance(words)))
    return found


def chance(words: dict[str, Any]) -> float | None:
    """Return the share of the evidence that an answer's first explanation has among all of as many effects."""
    behind = [
        model["behind"]
        for model in words.get("models", ())
        if len(model["names"]) == len(words["effects"]) and not model["refused"]
    ]
    return 1.0 / sum(math.exp(-0.5 * evidence) for evidence in behind) if behind else None


def share(values: Iterable[bool | None]) -> str:
    """Return a rate with its counts; what does not apply is not counted."""
    asked = [value for value in values if value is not None]
    return f"{np.mean(asked):.1%} ({sum(asked)} of {len(asked)})" if asked else "-"


def mean(values: Iterable[float | None]) -> str:
    """Return a mean as a share."""
    known = [value for value in values if value is not None]
    return f"{np.mean(known):.1%}" if known else "-"


def level(values: Iterable[float | None], *percentiles: float) -> str:
    """Return percentiles as shares."""
    known = [value for value in values if value is not None]
    return " / ".join(f"{value:.1%}" for value in np.percentile(known, percentiles)) if known else "-"


def rates(scores: list[Graded]) -> dict[str, str]:
    """Return every rate of one design by its name."""
    by_group = {group: [entry for entry in scores if entry.cell.group == group] for group in GROUPS}
    clean = [entry.grade for entry in by_group["clean"]]
    one, two = by_group["effects"], by_group["pairs"]
    outside = [entry.grade for entry in by_group["outside"] if entry.least("apart") >= 8.0]
    varied = [entry for entry in by_group["variants"] if entry.least("sigmas") >= SEEN]
    by_left = {
        LITTLE: [entry.grade for entry in varied if entry.told["left"] <= LEFT],
        MUCH: [entry.grade for entry in varied if entry.told["left"] > LEFT],
    }
    noisy: dict[str, list[bool]] = {}
    for entry in by_group["clean"]:
        noisy.setdefault(entry.cell.noise, []).append(entry.grade.false_alarm)
    claims = [entry for entry in one if entry.grade.named]
    sizes = [entry.grade.set_size for entry in claims if entry.grade.set_size is not None]
    far = [entry for entry in one if entry.least("apart") >= 8.0]
    near = [entry.grade for entry in one if 4.0 <= entry.least("apart") < 8.0]
    alone = [entry.grade for entry in two if entry.least("sigmas") >= 6.0]
    seen = [entry for entry in two if min(entry.least("sigmas"), entry.least("beside")) >= 6.0]
    large = [entry for entry in claims if entry.least("sigmas") >= 8.0]
    open_gaps = [entry for entry in claims if entry.told.get("gap", 0.0) >= VISIBLE]
    return {
        "false alarm on clean data": share(grade.false_alarm for grade in clean),
        "the same, worst noise": max((share(alarms) for alarms in noisy.values()), default="-", key=_first_number),
        "one effect, 8 sigma or more from every rival: named first": share(bool(entry.grade.top) for entry in far),
        "one effect, 4 to 8 sigma: named first": share(bool(grade.top) for grade in near),
        "one effect of any size: reported": share(bool(entry.grade.named) for entry in one),
        "of those: named first": share(entry.grade.top for entry in claims),
        "of those: the first name's chance by the evidence, on average": mean(entry.chance for entry in claims),
        "of those: truth in the reported set": share(entry.grade.in_set for entry in claims),
        "of those: mean set size": f"{np.mean(sizes):.2f}" if sizes else "-",
        "a name printed alone is right": share(entry.grade.alone_right for entry in one),
        "a second name on one effect": share(entry.grade.extra for entry in one),
        "one effect below 2 sigma: no name, and said to be too small to show": share(entry.unseen for entry in one),
        "of those that hide even at typical size: said which loads or columns would show it": share(
            entry.cured for entry in one
        ),
        "gap closed on locked rows, poses without noise, median / 5th percentile: of the mechanism as given": level(
            (entry.told.get("closed_since_given") for entry in claims), 50, 5
        ),
        "of the mechanism calibrated alone": level((entry.told.get("closed") for entry in claims), 50, 5),
        "both, were the hidden name the only one in the catalogue": "; ".join(
            level((entry.told.get(most) for entry in claims), 50, 5) for most in ("most_since_given", "most")
        ),
        "of the mechanism calibrated alone, where the effect stands out by 8 sigma or more": level(
            (entry.told.get("closed") for entry in large), 50, 5
        ),
        "of the mechanism calibrated alone, where that gap is 3 sigma or more": level(
            (entry.told.get("closed") for entry in open_gaps), 50, 5
        ),
        "and both as the noise lets it be seen": "; ".join(
            level((getattr(entry.grade, since) for entry in claims), 50, 5)
            for since in ("gap_closed_since_given", "gap_closed")
        ),
        "interval of the size holds the truth": share(_size_covered(entry.grade for entry in one)),
        **{
            f"one effect, of whose law the catalogue's leaves {much}: {what}": share(values)
            for much, grades in by_left.items()
            for what, values in (
                ("truth in the reported set", [bool(grade.in_set) for grade in grades]),
                ("named first", [bool(grade.top) for grade in grades]),
                ("a second name", [grade.extra for grade in grades]),
                ("one wrong name alone", [_wrong_alone(grade) for grade in grades]),
            )
        },
        "two effects, each 6 sigma or more when alone: both named": share(bool(grade.top) for grade in alone),
        "the same: both in the reported sets": share(bool(grade.in_set) for grade in alone),
        "two effects, each 6 sigma or more alone and beside the other: both named": share(
            bool(entry.grade.top) for entry in seen
        ),
        "and so, told two names: chance of both by the evidence, on average": mean(
            entry.chance for entry in seen if len(entry.grade.named) == 2
        ),
        "and so: both in the reported sets": share(bool(entry.grade.in_set) for entry in seen),
        "outside the catalogue, 8 sigma or more from every entry: said so": share(
            grade.verdict_right for grade in outside
        ),
        "outside the catalogue, 8 sigma or more from every entry: one name alone": share(
            grade.alone and len(grade.named) == 1 for grade in outside
        ),
        "outside the catalogue, 8 sigma or more from every entry: two names": share(
            len(grade.named) == 2 for grade in outside
        ),
    }


def _wrong_alone(grade: Score) -> bool:
    return len(grade.named) == 1 and grade.alone_right is False


def _first_number(text: str) -> float:
    return float(text.partition("%")[0]) if "%" in text else -1.0


def _size_covered(scores: Iterable[Score]) -> Iterator[bool]:
    """Yield whether the size of the hidden effect is held, where it is named and has an interval."""
    for grade in scores:
        size = CATALOGUE[grade.hidden[0]].size.name
        if grade.top and size in grade.covered:
            yield grade.covered[size]


def table(by_design: dict[str, dict[str, str]]) -> list[str]:
    """Return the lines of a table, one column a design."""
    names = [DESIGNS.get(design, design) for design in by_design]
    lines = [f"| | {' | '.join(names)} |", f"|---|{'---|' * len(names)}"]
    for what in next(iter(by_design.values()), ()):
        lines += [f"| {what} | {' | '.join(column[what] for column in by_design.values())} |"]
    return lines


def by_effect(scores: list[Graded]) -> dict[str, dict[str, str]]:
    """Return rates of every effect hidden alone."""
    groups: dict[str, list[Score]] = {}
    for cell, grade, *_ in scores:
        if cell.group in ("effects", "outside"):
            groups.setdefault(f"{cell.design} {cell.name}", []).append(grade)
    return {
        name: {
            "reported": share(bool(grade.named) for grade in grades),
            "first": share(grade.top for grade in grades if grade.named),
            "in_set": share(grade.in_set for grade in grades if grade.named),
        }
        for name, grades in groups.items()
    }


def main(words: list[str] | None = None, diagnose: Diagnose = diagnosed, tell: Tell = told) -> int:
    """Make what is missing, and write the rates to ``rates.json`` and, if asked, to `bench/RESULTS.md`."""
    args = _arguments(words)
    chosen = tuple(cells(args.groups, args.designs, tuple(args.noises), args.count))
    sets = {
        materials: [Sealed(cell, number, args.folder, args.seed, materials) for cell in chosen
                    for number in range(cell.count)] for materials in args.materials
    }  # fmt: skip
    task = partial(work, noises=tuple(args.noises), diagnose=None if args.generate_only else diagnose, tell=tell)
    lines, summary = list[str](), dict[str, Any]()
    for materials, own in sets.items():
        if args.forget:
            for sealed in own:
                sealed.answer.unlink(missing_ok=True)
        if not args.grade_only:
            print(f"{sum(_each(task, own, args.jobs))} of {len(own)} sets")
        if args.generate_only:
            continue
        scores = graded(own)
        done = {entry.cell.design for entry in scores}
        columns = {design: rates([entry for entry in scores if entry.cell.design == design])
                   for design in args.designs if design in done}  # fmt: skip
        lines += ["", MATERIALS[materials], "", *table(columns)]
        summary[materials] = {"rates": columns, "effects": by_effect(scores)}
    if args.generate_only:
        return 0
    write_whole(args.folder / "rates.json", json.dumps(summary, indent=1) + "\n")
    print("\n".join(lines))
    if args.write:
        results_page.put("error_rates", lines)
    return 0


def _each(task: Callable[[Sealed], bool], sets: list[Sealed], jobs: int) -> list[bool]:
    """Return what a task returns for every set."""
    if jobs < 2:
        return [task(sealed) for sealed in sets]
    with ProcessPoolExecutor(jobs) as pool:
        return list(pool.map(task, sets, chunksize=8))


def _arguments(words: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, required=True, help="where the sets are kept")
    parser.add_argument("--count", type=int, default=20, help="sets of a cell")
    parser.add_argument("--seed", type=int, default=0, help="of all sets; another number makes fresh ones")
    parser.add_argument("--groups", nargs="+", default=GROUPS, choices=GROUPS)
    parser.add_argument("--designs", nargs="+", default=[*DESIGNS])
    parser.add_argument("--noises", nargs="+", default=NOISES)
    parser.add_argument("--materials", nargs="+", default=[*MATERIALS], choices=[*MATERIALS], help="what is told")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--generate-only", action="store_true", help="make the sets, diagnose none")
    parser.add_argument("--grade-only", action="store_true", help="make and diagnose none, take the answers there are")
    parser.add_argument("--forget", action="store_true", help="throw away answers first")
    parser.add_argument("--write", action="store_true", help="write the table into bench/RESULTS.md")
    return parser.parse_args(words)


if __name__ == "__main__":
    raise SystemExit(main())
