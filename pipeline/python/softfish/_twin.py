"""Reduced tails of `study export twin`: stepped in real time, in air or in water."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from softfish import _core
from softfish._arguments import checked
from softfish._arrays import Array, ByName, flag, instance, named
from softfish._errors import InputError


class Twin:
    """A tail that steps in real time.

        tail = sf.Twin("tail.safetensors")
        state = tail.start()
        state.step({"left": 8e3}, 1e-3)
        state.outputs["m6_y"]                              # m

    Attributes:
        chambers: Lowest and highest pressure that the tail was reduced under, Pa, by the name of each chamber; others are refused.
        outputs: Coordinate at rest (m) of each displacement's point along its axis, by name.
        regions: Names of the solids.
        half: Whether half of a symmetric body is modelled: volumes are those of the half.
        provenance: Where it comes from: specimen, profile, version, records.
    """

    @checked()
    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._load(_core.Twin.read(os.fspath(path)))

    def _load(self, core: _core.Twin) -> None:
        self._core = core
        regions, chambers, ranges, outputs, at_rest, provenance, half = core.description()
        self.regions: tuple[str, ...] = tuple(regions)
        self.chambers: dict[str, tuple[float, float]] = {name: (low, high) for name, (low, high) in zip(chambers, ranges, strict=True)}
        self.outputs: dict[str, float] = dict(zip(outputs, at_rest, strict=True))
        self.provenance: dict[str, str] = dict(provenance)
        self.half: bool = half

    def __getstate__(self) -> bytes:
        return self._core.content()

    def __setstate__(self, state: bytes) -> None:
        self._load(_core.Twin.parse(state))

    def __repr__(self) -> str:
        name = self.provenance.get("specimen", "no specimen")
        return f"Twin({name}: {self.coordinates} coordinates, {len(self.chambers)} chambers, {len(self.outputs)} outputs)"

    @classmethod
    @checked(water=flag)
    def example(cls, *, water: bool = False) -> Twin:
        """A clamped beam of rubber with a chamber on either side, 0.1 m long."""
        return cls._of(_core.Twin.example(water))

    @classmethod
    def _of(cls, core: _core.Twin) -> Twin:
        twin = cls.__new__(cls)
        twin._load(core)
        return twin

    @checked()
    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes its arrays as safetensors."""
        Path(path).write_bytes(self._core.content())

    @property
    def coordinates(self) -> int:
        """Number of coordinates."""
        return self._core.coordinates()

    @property
    def page(self) -> str:
        """All that is needed to step its arrays without this package: axes, chambers, outputs, equations, integrator."""
        return self._core.page()

    def start(self) -> TwinState:
        """The tail at rest."""
        return TwinState(self, self._core.start())

    def restored(self, saved: bytes) -> TwinState:
        """The state that `TwinState.saved` gave, of this tail or one with the same arrays."""
        if not isinstance(saved, bytes):
            raise InputError(f"`saved` is {type(saved).__name__}", "a state is saved as bytes", "give what `TwinState.saved` returned")
        return TwinState(self, self._core.restored(saved))


class TwinState:
    """A moving tail: `Twin.start` gives it at rest.

    Attributes:
        twin: The tail that moves.
    """

    def __init__(self, twin: Twin, core: _core.TwinState) -> None:
        instance("twin", twin, Twin, "use Twin.start")
        self.twin = twin
        self._core = core

    def __getstate__(self) -> dict[str, Any]:
        return {"twin": self.twin, "saved": self.saved()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.twin = state["twin"]
        self._core = self.twin._core.restored(state["saved"])

    def __copy__(self) -> TwinState:
        return self.twin.restored(self.saved())

    def __repr__(self) -> str:
        return f"TwinState(at {self.time:.4f} s, {self.excursion:.2f} of the trained size)"

    @checked()
    def step(self, pressure: ByName, dt: float) -> None:
        """Steps by `dt` seconds, at whose end each chamber has its `pressure` (Pa); one without has none. A step that fails leaves the state as it was."""
        names = list(self.twin.chambers)
        self._core.step(named("chamber", names, np.zeros(len(names)), pressure, "pressure"), dt)

    @property
    def time(self) -> float:
        """s since the start."""
        return self._core.time()

    @property
    def coordinates(self) -> Array:
        """q, one per coordinate, no unit."""
        return self._core.coordinates()

    @property
    def velocity(self) -> Array:
        """q̇, one per coordinate, 1/s."""
        return self._core.velocity()

    @property
    def outputs(self) -> dict[str, float]:
        """Displacements, m, by name."""
        return dict(zip(self.twin.outputs, self._core.outputs().tolist(), strict=True))

    @property
    def volumes(self) -> dict[str, float]:
        """Volumes of the chambers, m³, by name."""
        return dict(zip(self.twin.chambers, self._core.volumes().tolist(), strict=True))

    @property
    def excursion(self) -> float:
        """The largest entry of q over that of the shapes which the tail was reduced from: above 1 its shape is extrapolated; no unit."""
        return self._core.excursion()

    def saved(self) -> bytes:
        """All that the next step depends on: `Twin.restored` goes on to the same bits."""
        return self._core.saved()
