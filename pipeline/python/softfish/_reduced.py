"""Reduced models: a body in a few dozen coordinates, stepped and differentiated step by step."""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from softfish import _core, _records
from softfish._arguments import checked, checked_constructor, counted
from softfish._arrays import Array, ByName, Sealed, copied, instance, named, number, reals, table, within
from softfish._errors import InputError

if TYPE_CHECKING:
    from softfish._jax_step import JaxStep
    from softfish._solver import Solver
    from softfish._torch_step import TorchStep


@checked_constructor
@dataclass(frozen=True)
class ReducedState:
    """Coordinates q and their rates, 1/s. Its arrays are read-only.

    Attributes:
        coordinates: q, one per coordinate, no unit.
        velocity: q̇, one per coordinate, 1/s.
    """

    coordinates: Array
    velocity: Array

    def __post_init__(self) -> None:
        for name in ("coordinates", "velocity"):
            object.__setattr__(self, name, copied(reals(name, getattr(self, name))))
        if self.coordinates.ndim != 1 or self.coordinates.shape != self.velocity.shape:
            shapes = f"{self.coordinates.shape} and {self.velocity.shape}"
            raise InputError(f"`coordinates` and `velocity` have the shapes {shapes}", "both are one per coordinate", "check their axes")


@dataclass(frozen=True)
class ReducedGradient:
    """The derivatives of a loss of the state after a step.

    Attributes:
        state: By the state before.
        pressures: By chamber, 1/Pa.
        modulus_scale: By the factor of the moduli of each region, no unit.
    """

    state: ReducedState
    pressures: Array
    modulus_scale: Array


@dataclass(frozen=True)
class ReducedStaticGradient:
    """The derivatives of a loss of the coordinates of an equilibrium.

    Attributes:
        pressures: By chamber, 1/Pa.
        E: By Young's modulus of each region, 1/Pa.
        nu: By Poisson's ratio of each region, no unit.
    """

    pressures: Array
    E: Array
    nu: Array


class ReducedModel(Sealed):
    """A body in the coordinates of a few modes, for many fast steps. Pressures act on it; gravity and forces of the case do not."""

    @checked()
    def __init__(self, solver: Solver, core: _core.ReducedModel, trained: Mapping[str, tuple[float, float]] | None = None) -> None:
        """Of the compiled model of a body: `Solver.reduce` and `ReducedModel.load` make it. `trained`: see the attribute."""
        from softfish._solver import Solver

        instance("solver", solver, Solver, "use Solver.reduce")
        instance("core", core, _core.ReducedModel, "use Solver.reduce")
        self._solver = solver
        self._core = core
        self._trained = {name: _range(name, pair) for name, pair in table("trained", {} if trained is None else trained).items()}

    def __getstate__(self) -> dict[str, Any]:
        data = self._core.data()
        model = {"modes": data["modes"], "points": data["points"], "size": data["size"]}
        return {"solver": self._solver, "trained": self._trained, **model}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self._solver = state["solver"]
        self._trained = state["trained"]
        self._core = self._solver._core.restore(state["modes"], state["points"], state["size"])

    def __repr__(self) -> str:
        points = sum(len(numbers) for numbers, _ in self._core.data()["points"])
        return f"ReducedModel({self.coordinates} coordinates, {points} quadrature points, {self._solver._nodes} nodes)"

    @classmethod
    @checked(coordinates=counted(1, 1000), tolerance=lambda name, value: within(name, value, 1e-12, 1.0))
    def of(cls, solver: Solver, snapshots: npt.ArrayLike, coordinates: int, tolerance: float) -> ReducedModel:
        """Of snapshots × nodes × 3, m: see `Solver.reduce`."""
        from softfish._solver import Solver

        instance("solver", solver, Solver, "use Solver.reduce")
        shapes = reals("snapshots", snapshots)
        if shapes.ndim != 3 or shapes.shape[1:] != solver.mesh.nodes.shape or not len(shapes):
            why = f"it is snapshots × {solver.mesh.nodes.shape[0]} × 3"
            raise InputError(f"`snapshots` has the shape {shapes.shape}", why, "check its axes")
        if not np.any(shapes):
            raise InputError("`snapshots` are all zero", "modes are directions in which the body moved", "give displaced shapes")
        return cls(solver, solver._core.reduce(shapes.reshape(-1), coordinates, tolerance))

    @property
    def coordinates(self) -> int:
        """Number of coordinates."""
        return self._core.coordinates()

    def rest(self) -> ReducedState:
        """The undeformed body at rest."""
        return ReducedState(np.zeros(self.coordinates), np.zeros(self.coordinates))

    @checked()
    def displacement(self, state: ReducedState) -> Array:
        """nodes × 3, m."""
        return self._core.displacement(self._pair(state)[0]).reshape(-1, 3)

    @checked()
    def output(self, name: str, state: ReducedState) -> Array:
        """The displacement of a point of the case: `marker.tip`."""
        return self._solver.observe(name, self.displacement(state))

    @checked()
    def output_rows(self, name: str) -> Array:
        """∂output/∂q of a point of the case, 3 × coordinates."""
        modes = self._core.data()["modes"].reshape(self.coordinates, -1, 3)
        return np.ascontiguousarray(self._solver.observe(name, modes).T)

    @property
    def trained(self) -> dict[str, tuple[float, float]]:
        """The ranges of a model that `study reduce` trained: `E.silicone` (Pa) and `nu.silicone` (no unit) of regions, pressures of chambers (Pa); else
        empty."""
        return dict(self._trained)

    @checked()
    def equilibrium(
        self,
        pressures: ByName | None = None,
        *,
        E: ByName | None = None,
        nu: ByName | None = None,
        near: ReducedState | None = None,
    ) -> ReducedState:
        """The stable equilibrium under `pressures` (Pa, by chamber; 0 where not given) of a body with these constants (by region; those of the
        solver where not given), searched from the state `near`, or from rest. What lies outside the ranges that the model was trained over is refused."""
        start = self._pair(self.rest() if near is None else near)[0]
        coordinates = self._core.equilibrium(start, self._constants(pressures, E, nu))
        return ReducedState(coordinates, np.zeros(self.coordinates))

    @checked()
    def equilibrium_gradient(
        self,
        state: ReducedState,
        loss: npt.ArrayLike,
        pressures: ByName | None = None,
        *,
        E: ByName | None = None,
        nu: ByName | None = None,
    ) -> ReducedStaticGradient:
        """The gradient of a loss of the coordinates of an equilibrium `state`, from its derivative `loss` by each, by the adjoint method."""
        by_coordinates = reals("loss", loss, (self.coordinates,))
        found = self._core.equilibrium_gradient(self._pair(state)[0], self._constants(pressures, E, nu), by_coordinates)
        return ReducedStaticGradient(*(np.array(part) for part in found))

    def _constants(
        self, pressures: ByName | None, E: ByName | None, nu: ByName | None
    ) -> tuple[list[float], list[tuple[float, float]]]:
        solver = self._solver
        by_chamber = solver._by_chamber(np.zeros(solver.chamber_count), pressures, "pressures").tolist()
        moduli = named("region", solver.regions, solver._base.youngs_modulus, E, "E").tolist()
        ratios = named("region", solver.regions, solver._base.poissons_ratio, nu, "nu").tolist()
        values = dict(zip(solver.chambers, by_chamber, strict=True))
        values |= {f"E.{name}": value for name, value in zip(solver.regions, moduli, strict=True)}
        values |= {f"nu.{name}": value for name, value in zip(solver.regions, ratios, strict=True)}
        for name, (low, high) in self._trained.items():
            if name in values and not low <= values[name] <= high:
                why = f"the model was trained from {low:g} to {high:g}"
                raise InputError(f"`{name}` is {values[name]:g}", why, "stay in that range, or reduce the body over a wider one")
        return by_chamber, list(zip(moduli, ratios, strict=True))

    @checked()
    def step(
        self,
        state: ReducedState,
        pressures: ByName | None = None,
        dt: float = 1e-3,
        *,
        modulus_scale: npt.ArrayLike | None = None,
        mass_damping: float = 0.0,
        stiffness_damping: float = 0.0,
    ) -> ReducedState:
        """The state after `dt` seconds (implicit Euler) under `pressures` (Pa, by chamber; 0 where not given)."""
        given = self._given(pressures, dt, modulus_scale, (mass_damping, stiffness_damping))
        return ReducedState(*self._core.step(self._pair(state), given))

    @checked()
    def step_gradient(
        self,
        states: tuple[ReducedState, ReducedState],
        loss: ReducedState,
        pressures: ByName | None = None,
        dt: float = 1e-3,
        *,
        modulus_scale: npt.ArrayLike | None = None,
        mass_damping: float = 0.0,
        stiffness_damping: float = 0.0,
    ) -> ReducedGradient:
        """The gradient of a loss of the state after a step, from its derivatives `loss`, at the states before and after."""
        given = self._given(pressures, dt, modulus_scale, (mass_damping, stiffness_damping))
        if not isinstance(states, tuple | list) or len(states) != 2:
            raise InputError(f"`states` is {states!r}", "it is the state before the step and that after it", "give both")
        pairs = (self._pair(states[0]), self._pair(states[1]))
        before, by_pressure, by_scale = self._core.step_gradient(pairs, given, self._pair(loss))
        return ReducedGradient(ReducedState(*before), np.array(by_pressure), np.array(by_scale))

    @checked()
    def torch_step(
        self,
        dt: float = 1e-3,
        *,
        modulus_scale: npt.ArrayLike | None = None,
        mass_damping: float = 0.0,
        stiffness_damping: float = 0.0,
    ) -> TorchStep:
        """A step of `dt` seconds as a function of PyTorch: (coordinates, velocity, pressures) to (coordinates, velocity), differentiable once
        in reverse and forward mode. A first axis of any argument is a batch."""
        from softfish._torch_step import TorchStep

        return TorchStep(self, dt, self._settings(dt, modulus_scale, (mass_damping, stiffness_damping)))

    @checked()
    def jax_step(
        self,
        dt: float = 1e-3,
        *,
        modulus_scale: npt.ArrayLike | None = None,
        mass_damping: float = 0.0,
        stiffness_damping: float = 0.0,
    ) -> JaxStep:
        """A step of `dt` seconds as a function of JAX: (coordinates, velocity, pressures) to (coordinates, velocity), differentiable once in
        reverse and forward mode; goes with `jax.jit`, `jax.lax.scan` and `jax.vmap`. Under `jax.jit` a step that fails is NaN, and `check()` raises its
        exception."""
        from softfish._jax_step import JaxStep

        return JaxStep(self, dt, self._settings(dt, modulus_scale, (mass_damping, stiffness_damping)))

    def _settings(self, dt: float, scale: npt.ArrayLike | None, damping: tuple[float, float]) -> dict[str, Any]:
        """The settings of steps, checked."""
        self._given(None, dt, scale, damping)
        return {"modulus_scale": scale, "mass_damping": damping[0], "stiffness_damping": damping[1]}

    @checked()
    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the model as safetensors: modes, sampled points and weights of each region."""
        data = self._core.data()
        tensors: dict[str, npt.NDArray[Any]] = {"modes": data["modes"].reshape(self.coordinates, -1, 3)}
        for region, (numbers, weights) in enumerate(data["points"]):
            tensors[f"points.{region}"] = np.array(numbers, dtype=np.int64)
            tensors[f"weights.{region}"] = np.array(weights, dtype=np.float64)
        tensors["size"] = np.array([data["size"]])
        _write(path, tensors)

    @classmethod
    @checked()
    def load(cls, path: str | os.PathLike[str], solver: Solver) -> ReducedModel:
        """The model that `save` wrote, of the same body."""
        from softfish._solver import Solver

        instance("solver", solver, Solver, "give the solver of the same body")
        tensors, metadata = _read(path)
        regions = len(solver.regions)
        names = ["modes", "size", *(f"{part}.{n}" for n in range(regions) for part in ("points", "weights"))]
        absent = [name for name in names if name not in tensors]
        if absent or tensors["modes"].shape[1:] != solver.mesh.nodes.shape:
            why = f"it lacks {', '.join(absent)}" if absent else f"its modes have the shape {tensors['modes'].shape}"
            raise InputError(f"{os.fspath(path)} is no reduced model of this body", why, "reduce the body again")
        if any(tensors[f"points.{n}"].min(initial=0) < 0 for n in range(regions)):
            raise InputError(f"{os.fspath(path)} is damaged", "a point has a number below 0", "reduce the body again")
        points = [(tensors[f"points.{n}"].tolist(), tensors[f"weights.{n}"].tolist()) for n in range(regions)]
        modes = reals("modes", tensors["modes"]).reshape(-1)
        return cls(solver, solver._core.restore(modes, points, float(tensors["size"][0])), _ranges(metadata, solver.chambers))

    def _pair(self, state: ReducedState) -> tuple[Array, Array]:
        instance("state", state, ReducedState, "give what rest or step returned")
        shape = (self.coordinates,)
        return reals("coordinates", state.coordinates, shape), reals("velocity", state.velocity, shape)

    def _given(
        self, pressures: ByName | None, dt: float, scale: npt.ArrayLike | None, damping: tuple[float, float]
    ) -> tuple[_records.DynamicSettings, list[float], list[float]]:
        solver = self._solver
        settings: _records.DynamicSettings = {
            "step": dt,
            "scheme": "implicit_euler",
            "mass_damping": damping[0],
            "stiffness_damping": damping[1],
            "tolerance": 1e-6,
            "memory": 0,
            "max_iterations": None,
            "timeout": None,
        }
        regions = len(solver.regions)
        factors = np.ones(regions) if scale is None else reals("modulus_scale", scale, (regions,))
        if np.any(factors <= 0.0):
            why = "it multiplies the modulus of a region"
            raise InputError(f"`modulus_scale` is {factors.min():g}", why, "give numbers above 0")
        return settings, solver._by_chamber(np.zeros(solver.chamber_count), pressures, "pressures").tolist(), factors.tolist()


def _range(name: str, pair: Any) -> tuple[float, float]:
    """Both ends of a range."""
    ends = reals(f"trained[{name!r}]", pair, (2,))
    return number(name, ends[0]), number(name, ends[1])


# The format of safetensors: the length of a header, the header in JSON, the numbers. Written here, so that the package needs
# numpy alone.
_TYPES: dict[str, np.dtype[Any]] = {"F64": np.dtype("<f8"), "F32": np.dtype("<f4"), "I64": np.dtype("<i8")}


def _write(path: str | os.PathLike[str], tensors: dict[str, npt.NDArray[Any]]) -> None:
    header: dict[str, Any] = {"__metadata__": {"content": "softfish reduced model"}}
    parts, start = [], 0
    for name, tensor in tensors.items():
        kind = "F64" if tensor.dtype.kind == "f" else "I64"
        part = np.ascontiguousarray(tensor, dtype=_TYPES[kind]).tobytes()
        header[name] = {"dtype": kind, "shape": list(tensor.shape), "data_offsets": [start, start + len(part)]}
        parts.append(part)
        start += len(part)
    text = json.dumps(header, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 8)
    with open(path, "wb") as file:
        file.write(struct.pack("<Q", len(text)) + text + b"".join(parts))


def _ranges(metadata: dict[str, str], chambers: list[str]) -> dict[str, tuple[float, float]]:
    """The ranges of constants and pressures over which a model was trained."""
    training = json.loads(metadata.get("training", "{}"))
    constants = {one["name"]: (one["low"], one["high"]) for one in training.get("constants", [])}
    pressures = [(one["low"], one["high"]) for one in training.get("pressures", [])]
    return constants | dict(zip(chambers, pressures, strict=False))


def _read(path: str | os.PathLike[str]) -> tuple[dict[str, npt.NDArray[Any]], dict[str, str]]:
    try:
        with open(path, "rb") as file:
            content = file.read()
        (length,) = struct.unpack("<Q", content[:8])
        header = json.loads(content[8 : 8 + length])
        data = content[8 + length :]
        metadata = header.pop("__metadata__", {})
        spans = {name: (of, data[slice(*of["data_offsets"])]) for name, of in header.items()}
        tensors = {name: np.frombuffer(part, _TYPES[of["dtype"]]).reshape(of["shape"]) for name, (of, part) in spans.items()}
        return tensors, metadata
    except (OSError, ValueError, KeyError, TypeError, struct.error) as error:
        raise InputError(f"{os.fspath(path)} cannot be read", str(error), "give a file that ReducedModel.save wrote") from error
