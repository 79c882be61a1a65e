"""Records of a project: what `study run` has made, as tables and arrays."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from softfish import _core
from softfish._arguments import checked
from softfish._arrays import file, text
from softfish._errors import Error, InputError
from softfish._optional import optional


class Record:
    """One record of a stage: tables, scalars and other files."""

    @checked(folder=file)
    def __init__(self, folder: str | os.PathLike[str]) -> None:
        if not Path(folder).is_dir():
            raise InputError(f"{os.fspath(folder)} is no record", "it is no folder", "ask a Project for it")
        #: Where it lies.
        self.folder = folder = Path(folder)
        #: Names of its files.
        self.files: list[str] = sorted(file.name for file in folder.iterdir() if file.is_file())

    @property
    def tables(self) -> list[str]:
        """Names of its tables."""
        return [name.removesuffix(".parquet") for name in self.files if name.endswith(".parquet")]

    @checked(name=text)
    def table(self, name: str | None = None, *, library: Literal["polars", "pandas"] = "polars") -> Any:
        """A table as a data frame of polars or pandas; the only one where no name is given."""
        path = self._file(name, ".parquet")
        try:
            return optional(library).read_parquet(path)
        except Error:
            raise
        except Exception as error:
            # of whatever class the library has for a damaged file
            raise _damaged(path, error) from error

    @checked(name=text)
    def arrays(self, name: str | None = None) -> dict[str, npt.NDArray[Any]]:
        """The columns of a table as arrays."""
        frame = self.table(name)
        return {column: np.asarray(frame[column].to_numpy()) for column in frame.columns}

    @checked(name=text)
    def scalars(self, name: str | None = None) -> Any:
        """The content of a JSON file; of the only one where no name is given."""
        path = self._file(name, ".json")
        try:
            return json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise _damaged(path, error) from error

    @checked(name=text)
    def bytes(self, name: str) -> bytes:
        """The bytes of a file."""
        return self._file(name, "").read_bytes()

    def _file(self, name: str | None, ending: str) -> Path:
        names = [file for file in self.files if file.endswith(ending)]
        wanted = names[0] if name is None and len(names) == 1 else f"{name or ''}".removesuffix(ending) + ending
        if wanted not in names:
            why = f"the record has {', '.join(names) or 'none'}"
            raise InputError(f"the record {self.folder} has no file `{wanted}`", why, "name one of them")
        return self.folder / wanted

    def __repr__(self) -> str:
        return f"Record({', '.join(self.files)})"


def _damaged(path: Path, error: Exception) -> InputError:
    return InputError(f"{path} cannot be read", str(error), "make the record again: study run")


class Project:
    """A project of the command line: its folder, and one of its profiles."""

    @checked(folder=file)
    def __init__(
        self, folder: str | os.PathLike[str] = ".", profile: Literal["paper", "quick", "population"] = "paper"
    ) -> None:
        root = Path(folder)
        if not (root / "study.toml").is_file():
            raise InputError(f"{root} is no project", "it has no study.toml", "name the folder that `study init` wrote")
        self._root, self._profile = root, profile
        base = root if profile == "paper" else root / "target" / profile
        #: The folder of its records.
        self.processed = base / "data" / "processed"

    @checked()
    def records(self, stage: str | None = None) -> list[str]:
        """The names of all records that are there: stage and subject."""
        found = sorted(path.parent.relative_to(self.processed).as_posix() for path in self.processed.glob("**/record"))
        return [name for name in found if stage is None or name.split("/")[0] == stage]

    @checked()
    def record(
        self, stage: str, specimen: str | None = None, item: str | None = None, *, stale: bool = False
    ) -> Record:
        """The record of a stage: of one `specimen`, of an `item` of it, or of the whole project.

        One that is not of the present cards, settings and recordings is refused, as `study plan` has it; with `stale` it is read as it is.
        """
        name = "/".join(part for part in (stage, specimen or "all", item) if part)
        folder = self.processed / name / "record"
        if not folder.is_dir():
            known = ", ".join(self.records(stage) or self.records()) or "none"
            raise InputError(f"there is no record `{name}`", f"there are {known}", f"make it: study run {stage}")
        if not stale:
            _core.require_record(self._root, self._profile, name)
        return Record(folder)
