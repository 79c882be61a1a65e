"""Identification of a material from recordings of a body in free vibration."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from softfish import _core
from softfish._arrays import Array, file


@dataclass(frozen=True)
class FittedLaw:
    """A law fitted to all recordings that a page marks so."""

    #: Its name in the table.
    name: str
    #: Names of its parameters.
    parameters: list[str]
    #: Their SI units.
    units: list[str]
    #: In SI units.
    mean: Array
    #: In SI units: parameters × parameters.
    covariance: Array
    #: Bayes' information criterion, relative to the best law's.
    criterion: float
    #: Whether the recordings support it.
    supported: bool


@dataclass(frozen=True)
class Fit:
    """The laws of a page, from the simplest to the richest."""

    #: Every law.
    laws: list[FittedLaw]
    #: Where table, metrics and figure lie.
    folder: Path
    #: What the command line prints.
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
        """That law's parameters, SI."""
        return self.law.mean

    @property
    def covariance(self) -> Array:
        """Their covariance, SI."""
        return self.law.covariance


def fit(
    page: str | os.PathLike[str], *, root: str | os.PathLike[str] = ".", out: str | os.PathLike[str] | None = None
) -> Fit:
    """Fits the laws of a page, as `study fit` does: its file, or its name among those of the project at `root`, below which
    recordings are looked for. Writes its table, metrics and figure into `out`, or beside the page."""
    folder_out = None if out is None else file("out", out)
    report, folder, laws = _core.fit(file("root", root), file("page", page), folder_out)
    made = []
    for name, parameters, mean, covariance, criterion, supported in laws:
        names, units = [of[0] for of in parameters], [of[1] for of in parameters]
        square = np.array(covariance).reshape(len(names), len(names))
        made.append(FittedLaw(name, names, units, np.array(mean), square, criterion, supported))
    return Fit(made, Path(folder), report)
