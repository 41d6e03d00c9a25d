"""What a model says of a wire, and where a recording differs from it."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional, Sequence, Tuple, Union

from . import _sinew
from ._columns import arrays, recorded
from ._errors import BadInput
from ._progress import Progress, told
from ._recordings import Table

RigFile = Union[str, "os.PathLike[str]"]
"""Path of a rig file, or its text (which has more than one line)."""

_PICTURES = {"report.html": "report_html", "picture.svg": "picture_svg", "improved.toml": "rig_toml"}


@dataclass(frozen=True)
class Parameter:
    """A parameter before and after a fit, in ``unit``."""

    given: float
    """In the rig file."""
    value: float
    """Fitted."""
    low: float
    """Lower end of the 90 % interval."""
    high: float
    """Upper end of the 90 % interval."""
    unit: str
    prior_sigma: float
    """1 σ of what is believed of it beforehand."""


@dataclass(frozen=True)
class Misfit:
    """Error of one sensor."""

    rmse: float
    """RMS, in the column's unit."""
    chi: float
    """Over the sensor's noise; 1 means that nothing is left to explain."""


@dataclass(frozen=True)
class EffectSize:
    """A fitted parameter of an effect, with its 90 % interval, in ``unit``."""

    value: float
    low: float
    high: float
    unit: str


@dataclass(frozen=True)
class Effect:
    """Physics that was left out and is needed."""

    id: str
    """Its name in the catalogue (docs/effects.md)."""
    says: str
    """What it does here, with numbers."""
    parameters: Dict[str, EffectSize]
    share: float
    """Share of what was wrong that it accounts for, 0..1."""
    grade: str
    """confirmed_on_another_programme, on_this_programme_only or suspected."""
    cannot_be_told_apart_from: List[str]
    """Effects that explain the recording as well."""
    evidence: Dict[str, float]
    """holdout_chi_before, holdout_chi_after, holdout_rise, delta_bic and p_value."""


@dataclass(frozen=True)
class Identified:
    """The same physics with the parameters that fit best."""

    parameters: Dict[str, Parameter]
    """By their keys in the rig file."""
    noise: Dict[str, float]
    """Noise of every sensor, RMS, by column."""
    as_given: Dict[str, Misfit]
    """By column, with the rig file as it is."""
    fitted: Dict[str, Misfit]
    """By column, with the parameters fitted."""
    warnings: List[str]
    rig_toml: str = field(repr=False)
    """The rig file with the fitted parameters, its comments kept."""

    def save(self, path: "os.PathLike[str] | str") -> None:
        """Writes the rig file with the fitted parameters."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.rig_toml)

    def to_pandas(self):
        """A DataFrame of the parameters, one row each."""
        from ._columns import pandas

        rows = {key: vars(parameter) for key, parameter in self.parameters.items()}
        return pandas().DataFrame.from_dict(rows, orient="index")

    def _repr_html_(self) -> str:
        from ._recordings import _digits, _table_html

        rows = [
            [key, _digits(p.given), _digits(p.value), f"{_digits(p.low)} to {_digits(p.high)}", p.unit]
            for key, p in self.parameters.items()
        ]
        fits = ", ".join(f"{column}: chi {self.as_given[column].chi:.3g} → {m.chi:.3g}" for column, m in self.fitted.items())
        return _table_html(["parameter", "given", "fitted", "90 % interval", "unit"], rows, fits)


@dataclass(frozen=True)
class Diagnosis:
    """Where model and recordings differ, and what physics was left out. In a notebook it shows its report."""

    verdict: str
    """agrees, parameters_off, physics_missing or unknown_physics."""
    summary: str
    """The answer in two or three sentences."""
    effects: List[Effect]
    """The effects that are needed, those borne out first, the larger share first."""
    equation: Optional[str]
    """The guilty equation; None where nothing is left."""
    chi_as_given: float
    """Error over noise on data kept back, with the rig file as it is."""
    chi_recalibrated: float
    """The same with parameters refitted."""
    chi_improved: float
    """The same with what was found in the model."""
    parameters: Dict[str, Parameter]
    next_experiment: str
    """What recording would tell more."""
    next_programme: Optional[Table]
    """The inputs of that recording, where one would settle something."""
    warnings: List[str]
    answer: Dict[str, Any] = field(repr=False)
    """The whole answer, as in ``diagnosis.json``."""
    rig_toml: str = field(repr=False)
    """The rig file with what was found in its model."""
    report_html: str = field(repr=False)
    """The report as a page that stands alone."""
    picture_svg: str = field(repr=False)
    """Measured against simulated, as a drawing."""

    def save(self, folder: "os.PathLike[str] | str") -> None:
        """Writes report.html, picture.svg, improved.toml and diagnosis.json, and next.csv where there is one. The folder is made;
        one with other things in it is left as it is and refused."""
        os.makedirs(folder, exist_ok=True)
        known = {*_PICTURES, "diagnosis.json", "next.csv"}
        strange = sorted(set(os.listdir(folder)) - known)
        if strange:
            raise BadInput(f"{folder}: has {strange[0]!r} in it", "choose a new folder, or an earlier answer's")

        def write(name: str, text: str) -> None:
            with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                file.write(text)

        for name, attribute in _PICTURES.items():
            write(name, getattr(self, attribute))
        write("diagnosis.json", json.dumps(self.answer, indent=2, ensure_ascii=False) + "\n")
        if self.next_programme is not None:
            self.next_programme.save(os.path.join(folder, "next.csv"))

    def _repr_html_(self) -> str:
        import html

        # a frame of its own: the page brings its styles along
        return f'<iframe style="width:100%;height:40em;border:0" srcdoc="{html.escape(self.report_html, quote=True)}"></iframe>'


def simulate(
    rig: RigFile,
    inputs: Any,
    *,
    channel: Optional[str] = None,
    ignore_columns: bool = False,
    catalogue: Optional[RigFile] = None,
    progress: Progress = None,
) -> Table:
    """What the model of a wire does under a recording's inputs.

    ``rig``: path or text of a rig file. ``inputs``: a recording (path, DataFrame, Arrow table, dict of arrays) with ``time_s`` in s
    and what drives the wire, usually ``duty`` (0..1); a row's inputs hold to the time of the next. ``channel``: which one, where the
    rig has several. ``catalogue``: physics of one's own (docs/own-physics.md).

    Returns the inputs and every sensor the model knows, each of shape (samples,): ``position_m`` (elongation, m), ``force_n``,
    ``temperature_c``, ``current_a``, ``v1_v`` …, ``martensite`` (0..1). Raises :class:`BadInput` with the place and the remedy.
    """
    with told(progress) as tell:
        columns = _sinew.simulate(rig, recorded(inputs, "inputs"), channel, ignore_columns, catalogue, tell)
    return Table(arrays(columns))


def identify(
    rig: RigFile,
    recordings: Any,
    *,
    channel: Optional[str] = None,
    ignore_columns: bool = False,
    catalogue: Optional[RigFile] = None,
    seed: int = 1,
    jobs: int = 0,
    progress: Progress = None,
) -> Identified:
    """The same physics with the parameters that fit best, each with its 90 % interval.

    ``recordings``: one or a list of them. ``seed``: another one keeps back other blocks for judging. ``jobs``: threads, 0 = as many
    as there are cores. The interpreter is free meanwhile, and Ctrl-C ends the work.
    """
    with told(progress) as tell:
        found = _sinew.identify(rig, _all(recordings), channel, ignore_columns, catalogue, seed, jobs, tell)
    answer = json.loads(found["json"])
    return Identified(
        parameters=_parameters(answer),
        noise=answer["noise"],
        as_given=_misfits(answer["fit"]["as_given"]),
        fitted=_misfits(answer["fit"]["recalibrated"]),
        warnings=answer["warnings"],
        rig_toml=found["rig_toml"],
    )


def diagnose(
    rig: RigFile,
    recordings: Any,
    *,
    holdout: Any = (),
    channel: Optional[str] = None,
    ignore_columns: bool = False,
    catalogue: Optional[RigFile] = None,
    seed: int = 1,
    jobs: int = 0,
    thorough: bool = False,
    progress: Progress = None,
) -> Diagnosis:
    """Where model and recordings differ, what physics was left out, and how much better the model is with it on data kept back.

    ``recordings``: one or a list of them. ``holdout``: recordings that are never fitted, by which the answer is judged; without,
    blocks of each recording are kept back. ``thorough``: search to the end, however long it takes. The interpreter is free
    meanwhile, and Ctrl-C ends the work.
    """
    with told(progress) as tell:
        found = _sinew.diagnose(
            rig,
            _all(recordings),
            _all(holdout, "holdout"),
            channel,
            ignore_columns,
            catalogue,
            seed,
            jobs,
            thorough,
            _command(seed, thorough),
            tell,
        )
    answer = json.loads(found["json"])
    next_programme = found["next_programme"]
    return Diagnosis(
        verdict=answer["verdict"],
        summary=answer["summary"],
        effects=[_effect(effect) for effect in answer["effects"]],
        equation=answer["where"]["equation"],
        chi_as_given=answer["left"]["chi_as_given"],
        chi_recalibrated=answer["left"]["chi"],
        chi_improved=answer["left"]["chi_improved"],
        parameters=_parameters(answer),
        next_experiment=answer["next_experiment"],
        next_programme=None if next_programme is None else Table(arrays(next_programme)),
        warnings=answer["warnings"],
        answer=answer,
        rig_toml=found["rig_toml"],
        report_html=found["report_html"],
        picture_svg=found["picture_svg"],
    )


def _command(seed: int, thorough: bool) -> str:
    more = ", thorough=True" if thorough else ""
    return f"sinew.diagnose(rig, recordings, seed={seed}{more})"


def _all(recordings: Any, name: str = "recording") -> list:
    """One recording, or a list of them, each under a name of its own."""
    several: Sequence = recordings if isinstance(recordings, (list, tuple)) else [recordings]
    named: List[Tuple[Any, str]] = [(r, name if len(several) == 1 else f"{name} {i}") for i, r in enumerate(several)]
    return [recorded(recording, called) for recording, called in named]


def _parameters(answer: Dict[str, Any]) -> Dict[str, Parameter]:
    return {key: Parameter(**row) for key, row in answer["parameters"].items()}


def _misfits(stage: Dict[str, Any]) -> Dict[str, Misfit]:
    return {column: Misfit(**row) for column, row in stage.items()}


def _effect(row: Dict[str, Any]) -> Effect:
    return Effect(
        id=row["id"],
        says=row["says"],
        parameters={key: EffectSize(**size) for key, size in row["parameters"].items()},
        share=row["share"],
        grade=row["grade"],
        cannot_be_told_apart_from=row["cannot_be_told_apart_from"],
        evidence=row["evidence"],
    )
