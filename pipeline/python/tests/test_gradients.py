"""Every gradient against differences of fourth order: parameters × cells × laws, of equilibria, motions and steps of reduced models."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np
import pytest

import softfish as sf

CELLS = ("linear", "quadratic", "hexahedra", "quadratic_hexahedra")
LAWS = [(law, False) for law in sf.MATERIALS] + [("neo_hookean", True)]
#: Largest relative error of a directional derivative: what tolerances of 1e-13 and steps of 1e-3 leave is below 1e-7.
LIMIT = 1e-6
STEPS, DT = 3, 2e-3
_WORST: dict[str, tuple[float, str]] = {}


@dataclass
class Body:
    """A hollow block of two regions, and a random direction for each parameter."""

    cells: str
    law: str
    mean_dilatation: bool
    generator: np.random.Generator = field(default_factory=lambda: np.random.default_rng(68))

    def __post_init__(self) -> None:
        box = sf.Mesh.box((0.03, 0.03, 0.03), (3, 3, 3), self.cells)
        corners = 8 if "hexahedra" in self.cells else 4
        middles = box.nodes[box.elements[:, :corners]].mean(axis=1)
        inside = np.all(np.abs(middles - 0.015) < 0.005, axis=1)
        mesh = sf.Mesh(box.nodes, box.elements[~inside], (middles[~inside, 2] > 0.015).astype(int))
        material = sf.Material(2e5, 0.4, 1000.0, self.law, self.mean_dilatation)
        self.solver = sf.Solver.of_mesh(mesh, material, mesh.nodes[:, 0] == 0.0)
        self.shape = mesh.nodes.shape
        # cavities of 8-node hexahedra are no chambers
        self.chambers = self.solver.chamber_count
        free = mesh.nodes[:, :1] > 0.0
        self.values: dict[str, Any] = {
            "E": np.array([2e5, 3e5]), "nu": np.array([0.4, 0.35]), "density": np.array([1000.0, 1200.0]),
            "forces": 1e-4 * free * self.random(self.shape), "element_E": 2e5 * (1.0 + 0.2 * self.random(len(mesh.elements))),
        }
        if self.chambers:
            self.values["pressure"] = np.array([2e3])

    def random(self, shape: Any) -> Any:
        return self.generator.uniform(-1.0, 1.0, shape)

    def direction(self, name: str) -> Any:
        """A change of a parameter in its own size."""
        value = np.asarray(self.values[name])
        return np.abs(value).max() * self.random(value.shape)


    def others(self, name: str) -> dict[str, Any]:
        """All parameters with the moduli of regions, or with those of elements where these are `name`."""
        return {key: value for key, value in self.values.items() if key != ("E" if name == "element_E" else "element_E")}


FIELDS = {
    "E": "youngs_modulus", "nu": "poissons_ratio", "density": "density", "pressure": "pressures", "forces": "forces", "element_E": "elements",
    "mass_damping": "mass_damping", "stiffness_damping": "stiffness_damping",
}


def difference(loss: Callable[[float], float], step: float = 1e-3) -> float:
    """The derivative at 0, by a central difference of fourth order."""
    near, far = loss(step) - loss(-step), loss(2 * step) - loss(-2 * step)
    return (8.0 * near - far) / (12.0 * step)


def compare(kind: str, body: Body, derivatives: dict[str, tuple[float, float]]) -> None:
    """Requires that pairs of an adjoint and a difference agree, and keeps the worst."""
    for name, (adjoint, by_difference) in derivatives.items():
        error = abs(adjoint - by_difference) / max(abs(adjoint), abs(by_difference), 1e-30)
        what = f"{name}, {body.cells}, {body.law}{' of mean dilatation' if body.mean_dilatation else ''}"
        _WORST[kind] = max(_WORST.get(kind, (0.0, "")), (error, what))
        assert error < LIMIT, (kind, what, adjoint, by_difference)


def arch() -> sf.Solver:
    """A shallow arch of two regions under a dead pressure, clamped at both ends, with the path of its equilibria."""
    box = sf.Mesh.box((0.06, 0.002, 0.004), (12, 1, 1), "quadratic")
    nodes = box.nodes + [0.0, 0.004, 0.0] * np.sin(np.pi * box.nodes[:, :1] / 0.06)
    in_middle = np.abs(box.nodes[box.elements[:, :4]].mean(axis=1)[:, 0] - 0.03) < 0.015
    mesh = sf.Mesh(nodes, box.elements, in_middle.astype(int), names={0: "ends", 1: "middle"})
    rubber = {"material": "neo_hookean", "poissons_ratio": 0.4, "density": 1000.0}
    case = {
        "region": [{**rubber, "name": "ends", "youngs_modulus": 1e6}, {**rubber, "name": "middle", "youngs_modulus": 1.5e6}],
        "clamp": [{"plane": {"x": 0.0}}, {"plane": {"x": 0.06}}],
        "load": [{"plane": {"z": 0.004}, "traction": [0.0, -400.0, 0.0]}],
        "static": {"levels": [1.0], "arc_length": {"branch": "primary", "max_step": 0.02}},
    }
    return sf.Case(case, mesh=mesh).solver()


@pytest.fixture(params=[(cells, *law) for cells in CELLS for law in LAWS], ids=lambda of: f"{of[0]}-{of[1]}{'-mean' if of[2] else ''}")
def body(request: pytest.FixtureRequest) -> Body:
    return Body(*request.param)


def test_gradients_of_equilibria(body: Body) -> None:
    slope, gravity = body.random(body.shape), [0.0, 3.0, -9.81]
    derivatives = {}
    for name in body.values:
        others, along = body.others(name), body.direction(name)

        def solve(way: float) -> sf.Equilibrium:
            changed = {**others, name: others[name] + way * along}  # noqa: B023
            return body.solver.equilibrium(**changed, gravity=gravity, tolerance=1e-13)

        gradient = getattr(solve(0.0).adjoint(slope), FIELDS[name])
        derivatives[name] = (float(np.sum(gradient * along)), difference(lambda way: float(np.sum(slope * solve(way).displacement))))
    compare("equilibria", body, derivatives)


def test_gradients_of_motions(body: Body) -> None:
    by_u, by_v = body.random((STEPS, *body.shape)), 1e-3 * body.random((STEPS, *body.shape))
    free = body.solver.mesh.nodes[:, :1] > 0.0
    start = [1e-5 * free * body.random(body.shape), 1e-2 * free * body.random(body.shape)]
    body.values |= {"mass_damping": 5.0, "stiffness_damping": 1e-3}
    if body.chambers:
        body.values["pressure"] = 2e3 * (1.0 + 0.3 * body.random((STEPS, 1)))
    derivatives = {}
    for name in [*body.values, "initial displacement", "initial velocity"]:
        others, initial = body.others(name), list(start)
        along = [free * body.random(body.shape) * np.abs(part).max() for part in start] if name not in body.values else body.direction(name)

        def solve(way: float) -> sf.Motion:
            settings = dict(others)  # noqa: B023
            begin = list(initial)  # noqa: B023
            if name in settings:  # noqa: B023
                settings[name] = settings[name] + way * along  # noqa: B023
            else:
                at = int(name == "initial velocity")  # noqa: B023
                begin[at] = begin[at] + way * along[at]  # noqa: B023
            return body.solver.simulate(STEPS, DT, **settings, initial=tuple(begin), gravity=[0.0, 3.0, -9.81], tolerance=1e-13)

        gradient = solve(0.0).adjoint(by_u, by_v)
        by = getattr(gradient, FIELDS.get(name, name.replace(" ", "_")))
        change = along if name in body.values else along[int(name == "initial velocity")]

        def loss(way: float) -> float:
            motion = solve(way)  # noqa: B023
            return float(np.sum(by_u * motion.displacement) + np.sum(by_v * motion.velocity))

        derivatives[name] = (float(np.sum(by * change)), difference(loss))
    compare("motions", body, derivatives)


def test_gradients_of_steps_of_reduced_models(body: Body) -> None:
    loads = [{"gravity": [0.0, p / 100.0, g], **({"pressure": p} if body.chambers else {})} for p in (1e3, 3e3) for g in (20.0, -20.0)]
    shapes = np.stack([body.solver.equilibrium(**load).displacement for load in loads])
    if body.mean_dilatation:
        with pytest.raises(sf.InputError, match="mean dilatation"):
            body.solver.reduce(shapes, 3)
        return
    model = body.solver.reduce(shapes, 3)
    count = model.coordinates
    values = {"coordinates": 1e-3 * body.random(count), "velocity": 1e-2 * body.random(count), "pressures": np.full(body.chambers, 2e3), "modulus_scale": np.array([1.1, 0.9])}
    loss_of = sf.ReducedState(body.random(count), 1e-3 * body.random(count))
    derivatives = {}
    for name, value in values.items():
        if not value.size:
            continue
        along = np.abs(value).max() * body.random(value.shape)

        def step(way: float) -> tuple[sf.ReducedState, sf.ReducedState, dict[str, Any]]:
            now = {**values, name: values[name] + way * along}  # noqa: B023
            before = sf.ReducedState(now.pop("coordinates"), now.pop("velocity"))
            settings = {**now, "mass_damping": 5.0, "stiffness_damping": 1e-3}
            return before, model.step(before, dt=DT, **settings), settings

        def loss(way: float) -> float:
            after = step(way)[1]  # noqa: B023
            return float(loss_of.coordinates @ after.coordinates + loss_of.velocity @ after.velocity)

        before, after, settings = step(0.0)
        gradient = model.step_gradient((before, after), loss_of, dt=DT, **settings)
        by = getattr(gradient.state, name) if hasattr(gradient.state, name) else getattr(gradient, name)
        derivatives[name] = (float(by @ along), difference(loss))
    compare("reduced steps", body, derivatives)


def test_gradients_of_equilibria_of_reduced_models(body: Body) -> None:
    if not body.chambers or body.mean_dilatation:
        pytest.skip("only pressures act on a reduced model, and it has no mean dilatation")
    states = product((1e3, 3e3), ([2e5, 3e5], [3e5, 2e5]), ([0.4, 0.38], [0.35, 0.38]))
    shapes = [body.solver.equilibrium(pressure=p, E=E, nu=nu).displacement for p, E, nu in states]
    model = body.solver.reduce(np.stack(shapes), 6)
    values = {name: body.values[name] for name in ("pressure", "E", "nu")}
    loss_of, derivatives = body.random(model.coordinates), {}

    def solve(values: dict[str, Any]) -> sf.ReducedState:
        return model.equilibrium(values["pressure"], E=values["E"], nu=values["nu"])

    gradient = model.equilibrium_gradient(solve(values), loss_of, values["pressure"], E=values["E"], nu=values["nu"])
    for name, by in (("pressure", gradient.pressures), ("E", gradient.E), ("nu", gradient.nu)):
        along = body.direction(name)

        def loss(way: float) -> float:
            return float(loss_of @ solve({**values, name: values[name] + way * along}).coordinates)  # noqa: B023

        derivatives[name] = (float(by @ along), difference(loss))
    compare("reduced equilibria", body, derivatives)


def test_gradients_stay_right_near_a_fold_and_give_the_derivative_of_its_load() -> None:
    solver = arch()
    fold = solver.path().critical[0]
    assert fold.kind == "limit_point" and 0.05 < fold.level < 0.95
    slope, along, errors = fold.mode, np.array([1e6, 0.5e6]), {}
    for distance in (1e-1, 1e-2, 1e-3, 1e-4):
        guess = fold.displacement

        def solve(way: float) -> sf.Equilibrium:
            moduli = np.array([1e6, 1.5e6]) + way * along
            level = fold.level * (1.0 - distance)  # noqa: B023
            return solver.equilibrium(E=moduli, level=level, initial_guess=guess, tolerance=1e-13)  # noqa: B023

        at = solve(0.0)
        guess = at.displacement
        by_adjoint = float(at.adjoint(slope).youngs_modulus @ along)
        # the fold moves with the moduli: differences stay well on its stable side
        by_difference = difference(lambda way: float(np.sum(slope * solve(way).displacement)), 2e-3 * distance)
        errors[distance] = abs(by_adjoint / by_difference - 1.0)
    _WORST["equilibria near a fold"] = max((error, f"at {distance:g} below its load") for distance, error in errors.items())
    assert all(error < 1e-5 for error in errors.values()), errors
    # the displacement along the critical mode is what the load depends on, to first order not at all at the fold
    gradient = solver.equilibrium(level=fold.level * (1.0 - 1e-6), initial_guess=fold.displacement, tolerance=1e-11).adjoint(slope)
    by_moduli = -gradient.youngs_modulus / np.sum(gradient.forces * solver.base.forces)
    assert by_moduli @ [1e6, 1.5e6] == pytest.approx(fold.level, rel=1e-5)
    limits = [solver.path(E={"middle": 1.5e6 * (1.0 + way)}).critical[0].level for way in (1e-3, -1e-3)]
    assert by_moduli[1] * 1.5e6 == pytest.approx((limits[0] - limits[1]) / 2e-3, rel=2e-3)


@pytest.mark.parametrize("exponent", [-300, -150, -20, -12, 12, 150, 250])
def test_gradients_are_linear_in_the_derivative_of_the_loss(exponent: int) -> None:
    body = Body("quadratic", "neo_hookean", False)
    rest, motion = body.solver.equilibrium(gravity=[0.0, 3.0, -9.81]), body.solver.simulate(STEPS, DT, gravity=[0.0, 3.0, -9.81])
    scale = 2.0 ** round(exponent / np.log10(2.0))
    for result in (rest, motion):
        slope = body.random(result.displacement.shape)
        one, other = result.adjoint(slope), result.adjoint(scale * slope)
        for name in ("youngs_modulus", "poissons_ratio", "density", "elements", "forces"):
            assert np.allclose(getattr(other, name) / scale, getattr(one, name), rtol=1e-9, atol=0.0), name
        changed = result.sensitivity(E=[1e5, 2e5])
        assert np.allclose(result.sensitivity(E=[1e5 * scale, 2e5 * scale]) / scale, changed, rtol=1e-9, atol=1e-12 * np.abs(changed).max())


def test_the_worst_errors_are_printed(capsys: pytest.CaptureFixture[str]) -> None:
    with capsys.disabled():
        for kind, (error, what) in _WORST.items():
            print(f"\nworst error of a gradient of {kind}: {error:.1e} ({what})", end="")
    assert all(error < LIMIT * 10.0 for error, _ in _WORST.values())
