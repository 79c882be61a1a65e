"""Each thing that a case may have: the same frames from the command line and from Python, and a gradient that differences confirm."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import softfish as sf
from test_case import written
from test_gradients import difference

HEAD = """
gravity = [0.0, 0.0, -9.81]
mesh = {{ file = "body.vtu", unit = "m" }}
clamp = [{{ plane = {{ x = 0.0 }} }}]
output = {{ vtu_every = 1 }}
[[region]]
tag = 0
material = "neo_hookean"
youngs_modulus = 2e5
poissons_ratio = 0.4
density = 1000.0
{region}
[[region]]
tag = 1
material = "yeoh"
stiffening = [0.1, 0.01]
youngs_modulus = 3e5
poissons_ratio = 0.45
density = 1100.0
"""
LEVELS, STEPS = "[static]\nlevels = [0.5, 1.0]\n", "[dynamic]\nduration = 0.006\nstep = 0.002\n"
DAMPED = STEPS + "stiffness_damping = 1e-3\n"
BRANCH = "branch = [{ strength = 0.3, time = 0.01 }]\nmodulus_time = 0.02"
SINE = "{ sine = { mean = 1e3, amplitude = 2e3, frequency = 50.0 } }"
MASS = '[[mass]]\nnear = [0.05, 0.015, 0.03]\nmass = 0.002\nhangs = "z"\n'
CONTACT = "[contact]\nrange = 4e-3\npressure = 2e4\n"


def air(pressure: str, more: str = "") -> str:
    return f'[[chamber]]\nname = "air"\nnumber = 0\npressure = {pressure}\n{more}\n'


FEATURES = {
    "sealed": ("", air("2e3", "sealed_in = 101325.0") + LEVELS),
    "history of levels": ("", air("{ ramp = { from = 0.0, to = 4e3, start = 0.0, seconds = 2.0 } }") + LEVELS),
    "dead pressure": ("", "[[load]]\ninside = [0.025, 0.015, 0.015]\npressure = 2e3\n" + LEVELS),
    "mass": ("", air("3e3") + MASS + LEVELS),
    "layer": ("", air("3e3") + "[[mass]]\nplane = { x = 0.05 }\narea_density = 2.0\n" + LEVELS),
    "contact": ("", air("-2e4") + CONTACT + LEVELS),
    "relaxation at rest": (BRANCH, air("3e3") + LEVELS),
    "sine": ("", air(SINE) + DAMPED),
    "sealed in motion": ("", air("0.0", "sealed_in = 101325.0") + DAMPED),
    "start": ("", air(SINE) + DAMPED + 'start = "equilibrium"\n'),
    "hanging mass in motion": ("", air("3e3") + MASS + STEPS + 'scheme = "implicit_euler"\nmass_damping = 3.0\n'),
    "relaxation": (BRANCH, air("3e3") + DAMPED),
    "relaxation from its start": (BRANCH, air("3e3") + DAMPED + 'start = "equilibrium"\n'),
    "creep": (BRANCH, air("3e3") + STEPS + 'scheme = "quasi_static"\n'),
    "lumped mass": ("", air("3e3") + DAMPED + "lumped_mass = true\n"),
    "contact in motion": ("", air("-2e4") + CONTACT + DAMPED),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """With a hollow block of two regions in a file."""
    pytest.importorskip("meshio")
    box = sf.Mesh.box((0.05, 0.03, 0.03), (5, 3, 3), "quadratic")
    middle = box.nodes[box.elements[:, :4]].mean(axis=1)
    solid = np.any(np.abs(middle - [0.025, 0.015, 0.015]) >= [0.015, 0.005, 0.005], axis=1)
    made = tmp_path_factory.mktemp("features")
    sf.Mesh(box.nodes, box.elements[solid], (middle[solid, 0] > 0.025).astype(int)).to_meshio().write(made / "body.vtu")
    return made


@pytest.mark.parametrize("name", FEATURES)
def test_a_feature_means_the_same_both_ways_and_has_its_gradient(name: str, folder: Path) -> None:
    region, rest = FEATURES[name]
    page = folder / f"{name.replace(' ', '_')}.toml"
    page.write_text(HEAD.format(region=region) + rest)
    case = sf.Case(page)
    frames, body = written(case.run(folder / page.stem)), case.solver()

    def solve(**given: Any) -> sf.Equilibrium | sf.Motion:
        return body.equilibrium(tolerance=1e-13, **given) if body.levels else body.simulate(tolerance=1e-13, **given)

    mine = body.equilibria()[-1].displacement if body.levels else body.simulate().displacement[-1]
    assert np.abs(frames[-1] - mine).max() <= 1e-12 < np.abs(frames).max()
    generator, base, result = np.random.default_rng(68), body.base, solve()
    slope = generator.uniform(-1.0, 1.0, result.displacement.shape)
    free = body.mesh.nodes[:, :1] > 0.0
    along = {"E": [2e4, -3e4], "nu": [0.01, 0.02], "density": [100.0, -50.0], "forces": 1e-4 * free * generator.uniform(-1.0, 1.0, base.forces.shape)}
    fields = {"E": "youngs_modulus", "nu": "poissons_ratio", "density": "density", "forces": "forces"}
    if body.chambers:
        along["pressure"], fields["pressure"] = 200.0 * generator.uniform(-1.0, 1.0, result.pressures.shape), "pressures"
    # a start under other pressures is that of the case
    if isinstance(result, sf.Motion) and result.start is not None:
        del along["pressure"]
    whole = {"pressure": result.pressures, **{key: getattr(base, fields[key]) for key in fields if key != "pressure"}}

    def loss(way: float) -> float:
        return float(np.sum(slope * solve(**{key: whole[key] + way * np.asarray(part) for key, part in along.items()}).displacement))

    gradient = result.adjoint(slope)
    by_adjoint = sum(float(np.sum(getattr(gradient, fields[key]) * part)) for key, part in along.items())
    assert by_adjoint == pytest.approx(difference(loss, 0.01), rel=1e-6)
