"""Identification of a material from recordings of a body in free vibration."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from softfish import _core
from softfish._arguments import checked
from softfish._arrays import Array


@dataclass(frozen=True)
class FittedLaw:
    """A law fitted to all recordings that a page marks so.

    Attributes:
        name: Its name in the table.
        parameters: Names of its parameters.
        units: Their SI units.
        mean: One per parameter, in SI units.
        covariance: In SI units: parameters × parameters.
        criterion: Bayes' information criterion, relative to the best law's; no unit.
        supported: Whether the recordings support it.
    """

    name: str
    parameters: list[str]
    units: list[str]
    mean: Array
    covariance: Array
    criterion: float
    supported: bool


@dataclass(frozen=True)
class Fit:
    """The laws of a page, from the simplest to the richest.

    Attributes:
        laws: Every law.
        folder: Where table, metrics and figure lie.
        report: What the command line prints.
    """

    laws: list[FittedLaw]
    folder: Path
    report: str

    @property
    def law(self) -> FittedLaw:
        """The law that the recordings support."""
        return next(law for law in self.laws if law.supported)

    @property
    def parameters(self) -> list[str]:
        """Names of that law's parameters."""
        return self.law.parameters

    @property
    def mean(self) -> Array:
        """One per parameter of that law, in SI units."""
        return self.law.mean

    @property
    def covariance(self) -> Array:
        """Their covariance, parameters × parameters, in SI units."""
        return self.law.covariance


@checked()
def fit(
    page: str | os.PathLike[str], *, root: str | os.PathLike[str] = ".", out: str | os.PathLike[str] | None = None
) -> Fit:
    """Fits the laws of a page, as `study fit` does: its file, or its name among those of the project at `root`, below which
    recordings are looked for. Writes its table, metrics and figure into `out`, or beside the page."""
    folder_out = None if out is None else os.fspath(out)
    report, folder, laws = _core.fit(os.fspath(root), os.fspath(page), folder_out)
    made = []
    for name, parameters, mean, covariance, criterion, supported in laws:
        names, units = [of[0] for of in parameters], [of[1] for of in parameters]
        square = np.array(covariance).reshape(len(names), len(names))
        made.append(FittedLaw(name, names, units, np.array(mean), square, criterion, supported))
    return Fit(made, Path(folder), report)
