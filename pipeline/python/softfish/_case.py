"""Cases: one body under loads, from a file or built in Python."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from softfish import _core
from softfish._arguments import checked
from softfish._arrays import Sealed, file, instance
from softfish._errors import InputError
from softfish._mesh import Mesh

if TYPE_CHECKING:
    from softfish._solver import Solver


def _plain(value: Any) -> Any:
    """Arrays and numbers of numpy as lists and numbers."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is no entry of a case")


class Case(Sealed):
    """One body under loads: the mesh, its materials, clamps, chambers, loads, and how it is solved.

    The keys are those of a case file of the command line, `study simulate --help` shows them all.

    Attributes:
        path: The file that it was read from; none of one that was built in Python.
    """

    path: Path | None

    @checked()
    def __init__(self, source: str | os.PathLike[str] | Mapping[str, Any], mesh: Mesh | None = None) -> None:
        """From a file of TOML, or from a dictionary with its keys; `mesh` takes the place of the one that it names."""
        if mesh is not None:
            instance("mesh", mesh, Mesh, "make one: Mesh.read, Mesh.from_meshio")
        if isinstance(source, Mapping):
            keys = dict(source)
            if mesh is not None:
                keys["mesh"] = {"file": "given", "unit": "m", "half": mesh.half}
            try:
                text = json.dumps(keys, default=_plain, allow_nan=False)
            except (TypeError, ValueError) as error:
                why = "a case holds numbers, texts, lists and dictionaries"
                raise InputError(f"the case cannot be written: {error}", why, "correct the entry") from error
            self._parse("json", text, str(Path.cwd() / "case.toml"))
            self.path = None
        else:
            self.path = Path(file("source", source))
            self._core = _core.Case.read(os.fspath(self.path))
            self._source = ("file", "", str(self.path.absolute()))
        self._mesh = mesh
        self._given = mesh is not None

    def _parse(self, kind: str, text: str, path: str) -> None:
        make = {"json": _core.Case.parse_json, "toml": _core.Case.parse}[kind]
        self._core = make(text, path)
        self._source = (kind, text, path)

    @classmethod
    @checked(folder=file)
    def from_toml(cls, text: str, folder: str | os.PathLike[str] = ".") -> Case:
        """From a text of TOML; meshes are named relative to `folder`."""
        if not isinstance(text, str):
            raise InputError(f"`text` is a {type(text).__name__}", "it is a text of TOML", "pass a file to Case itself")
        place = Path(folder).absolute()
        case = cls.__new__(cls)
        case.path = None
        case._mesh = None
        case._given = False
        case._parse("toml", text, str(place / "case.toml"))
        return case

    @property
    def mesh(self) -> Mesh:
        """The mesh, read at first use."""
        if self._mesh is None:
            self._mesh = Mesh._of(self._core.mesh())
        return self._mesh

    @checked()
    def solver(self, *, threads: int | None = None) -> Solver:
        """A solver, which keeps its factor from solve to solve; with `threads` of its own, or all processors."""
        from softfish._solver import Solver

        return Solver(self, threads=threads)

    @checked()
    def run(
        self,
        out: str | os.PathLike[str] | None = None,
        *,
        quiet: bool = True,
        max_iterations: int | None = None,
        max_cutbacks: int | None = None,
        timeout: float | None = None,
    ) -> Path:
        """Solves the case in its file as `study simulate` does, to the byte, and returns the folder of its results; the limits are those of
        `Solver.equilibrium`, in the place of the case's."""
        if self.path is None:
            raise InputError("a case that was built in Python is not run", "its files have no folder", "write it to a file")
        if self._given:
            raise InputError("a case with a given mesh is not run", "its file names another mesh", "use the solver")
        output = (None if out is None else os.fspath(out), quiet)
        folder, _, _ = _core.run_case(os.fspath(self.path), output, (max_iterations, max_cutbacks, timeout))
        return Path(folder)

    def __getstate__(self) -> dict[str, Any]:
        kind, text, path = self._source
        if kind == "file":
            # the text, so that a copy is the same case whatever becomes of the file
            kind, text = "toml", self._core.text()
        return {"source": (kind, text, path), "path": self.path, "mesh": self._mesh, "given": self._given}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self._parse(*state["source"])
        self.path, self._mesh, self._given = state["path"], state["mesh"], state["given"]

    def __repr__(self) -> str:
        name = "built in Python" if self.path is None else str(self.path)
        return f"Case({name}, {self._core.summary()})"
