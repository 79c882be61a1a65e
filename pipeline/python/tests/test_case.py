"""One meaning of a case: the command line and the package give the same answer, or the key is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import softfish as sf
from conftest import EXAMPLES

RUBBER = {"material": "neo_hookean", "youngs_modulus": 2e5, "poissons_ratio": 0.4, "density": 1000.0}
CASES = sorted(path.stem for path in EXAMPLES.glob("*.toml"))


def written(folder: Path, pattern: str = "frame_*.vtu") -> np.ndarray:
    """The displacements of the frames that the command line wrote: frames × nodes × 3."""
    meshio = pytest.importorskip("meshio")
    return np.stack([meshio.read(path).point_data["displacement_m"] for path in sorted(folder.glob(pattern))])


def solved(body: sf.Solver) -> np.ndarray:
    """The same from Python; of a motion, from the initial state on."""
    try:
        return body.path().displacement
    except sf.InputError:
        if body.levels:
            return np.stack([found.displacement for found in body.equilibria()])
    motion = body.simulate()
    start = np.zeros(motion.displacement.shape[1:]) if motion.start is None else motion.start.displacement
    return np.concatenate([start[None], motion.displacement])


def test_there_are_examples_of_every_kind() -> None:
    assert {"cantilever", "column", "creep", "finger", "free_vibration", "swing", "tension"} <= set(CASES)


@pytest.mark.parametrize("name", CASES)
def test_every_example_is_solved_as_the_command_line_does(name: str, tmp_path: Path) -> None:
    case = sf.Case(EXAMPLES / f"{name}.toml")
    frames = written(case.run(tmp_path))
    mine = solved(case.solver())
    every = 10 if case.solver().levels == [] else 1
    assert frames.shape == mine[::every].shape and np.abs(frames).max() > 1e-4
    assert np.abs(frames - mine[::every]).max() <= 1e-12


def beam(tmp_path: Path, keys: str) -> sf.Case:
    """The cantilever with other keys in the place of its load and levels, as a file that the command line can run."""
    text = (EXAMPLES / "cantilever.toml").read_text()
    head, tail = text[: text.index("[[load]]")], text[text.index("[output]") :]
    where = (EXAMPLES / "cantilever.msh").as_posix()
    page = tmp_path / "beam.toml"
    page.write_text((head + keys + tail).replace("cantilever.msh", where).replace("quadratic", "linear"))
    return sf.Case(page)


LOAD = "[[load]]\nplane = { x = 0.1 }\ntraction = [0.0, 0.0, -700.0]\n"


@pytest.mark.parametrize("keys", [
    LOAD + "[static]\nlevels = [0.3, 1.0]\n",
    LOAD + "[static]\nlevels = [1.0, 0.3]\n",
    LOAD + "[static]\nlevels = [0.5]\nload_steps = 5\ntolerance = 1e-6\n",
    LOAD + '[dynamic]\nduration = 0.02\nstep = 0.002\nstart = "equilibrium"\n',
    LOAD + "[dynamic]\nduration = 0.02\nadaptive = { tolerance = 1e-5, shortest = 1e-4, longest = 4e-3 }\n",
    LOAD + '[dynamic]\nduration = 0.01\nstep = 0.001\nscheme = "implicit_euler"\nmass_damping = 3.0\nstiffness_damping = 1e-3\n',
    LOAD + "[static]\nlevels = [0.01]\narc_length = { max_step = 0.02 }\n",
])
def test_each_key_means_what_it_means_to_the_command_line(keys: str, tmp_path: Path) -> None:
    case = beam(tmp_path, keys)
    text = case.path.read_text().replace("[output]", "[output]\nvtu_every = 1")
    case.path.write_text(text)
    case = sf.Case(case.path)
    frames, mine = written(case.run(tmp_path / "out")), solved(case.solver())
    assert frames.shape == mine.shape and np.abs(frames).max() > 1e-5
    assert np.abs(frames - mine).max() <= 1e-12


def test_the_last_level_is_the_default_and_is_reached_over_those_before(tmp_path: Path) -> None:
    body = beam(tmp_path, LOAD + "[static]\nlevels = [1.0, 0.3]\n").solver()
    levels = body.equilibria()
    last = body.equilibrium()
    assert last.level == 0.3 and np.array_equal(last.displacement, levels[-1].displacement)
    assert np.array_equal(body.equilibrium(level=1.0).displacement, levels[0].displacement)


def bar(**keys: object) -> sf.Solver:
    box = sf.Mesh.box((0.1, 0.01, 0.006), (10, 1, 1))
    output = {"node": [{"name": "tip", "near": [0.1, 0.0, 0.0]}]}
    return sf.Case({"region": [RUBBER], "clamp": [{"plane": {"x": 0.0}}], "output": output, **keys}, mesh=box).solver()


def test_forces_are_multiplied_by_the_level() -> None:
    body = bar(load=[{"plane": {"x": 0.1}, "traction": [0.0, 0.0, -5.0]}], static={"levels": [0.1, 1.0]})
    tenth = body.equilibrium(level=0.1).output("node.tip")[2]
    assert tenth == pytest.approx(body.equilibrium(forces=0.1 * body.base.forces).output("node.tip")[2], rel=1e-9)
    assert tenth == pytest.approx(body.equilibrium(inputs=body.inputs(level=0.1)).output("node.tip")[2], rel=1e-9)
    assert tenth == pytest.approx(body.equilibrium(inputs=body.inputs(), level=0.1).output("node.tip")[2], rel=1e-9)
    assert abs(body.equilibrium().output("node.tip")[2] / tenth) > 9.0


def test_a_motion_begins_in_the_equilibrium_that_the_case_asks_for_and_its_gradient_knows() -> None:
    dynamic = {"duration": 0.01, "step": 0.005, "start": "equilibrium"}
    body = bar(gravity=[0.0, 0.0, -9.81], dynamic=dynamic)
    still = body.simulate(tolerance=1e-11)
    rest = body.equilibrium().output("node.tip")[2]
    assert np.allclose(still.output("node.tip")[:, 2], rest, rtol=1e-6)
    slope = np.zeros_like(still.displacement)
    nodes, weights = body._weights("node.tip")
    slope[-1, nodes, 2] = weights
    gradient = still.adjoint(slope)

    def tip(E: float) -> float:
        return float(body.simulate(E=E, tolerance=1e-11).output("node.tip")[-1, 2])

    difference = (tip(2.002e5) - tip(1.998e5)) / 400.0
    assert gradient.youngs_modulus[0] == pytest.approx(difference, rel=1e-4)
    with pytest.raises(sf.DerivativeError, match="no forward sensitivities"):
        still.sensitivity(E=1.0)


def test_a_path_is_not_solved_for_as_levels() -> None:
    text = (EXAMPLES / "column.toml").read_text().replace("quadratic", "linear").replace("levels = [1.1]", "levels = [12.0]")
    body = sf.Case.from_toml(text, EXAMPLES).solver()
    with pytest.raises(sf.InputError, match="use path"):
        body.equilibrium()
    path = body.path()
    assert path.critical[0].kind == "bifurcation" and path.critical[0].level == pytest.approx(2.75, abs=0.05)
    on_branch = body.equilibrium(initial_guess=path.displacement[-1], level=float(path.levels[-1]))
    assert np.abs(on_branch.displacement - path.displacement[-1]).max() < 1e-5


def test_adaptive_steps_have_a_gradient(tmp_path: Path) -> None:
    keys = LOAD + "[dynamic]\nduration = 0.01\nadaptive = { tolerance = 1e-5, shortest = 1e-4, longest = 4e-3 }\n"
    body = beam(tmp_path, keys).solver()
    motion = body.simulate()
    assert len(set(np.round(np.diff(motion.times), 12))) > 1
    gradient = motion.adjoint(np.ones_like(motion.displacement))
    assert np.isfinite(gradient.youngs_modulus).all() and gradient.youngs_modulus[0] != 0.0
    with pytest.raises(sf.InputError, match="`steps` has no effect"):
        body.simulate(steps=5)


def test_tables_of_forces_act_on_a_given_mesh_too(tmp_path: Path) -> None:
    (tmp_path / "forces.csv").write_text("x_m,y_m,z_m,fx_n,fy_n,fz_n\n0.1,0.005,0.003,0.0,0.0,-1e-3\n")
    text = f"""
        mesh = {{ file = "{(EXAMPLES / 'cantilever.msh').as_posix()}", unit = "mm" }}
        clamp = [{{ plane = {{ x = 0.0 }} }}]
        load = [{{ table = "forces.csv" }}]
        static = {{ levels = [1.0] }}
        [[region]]
        material = "neo_hookean"
        youngs_modulus = 1e6
        poissons_ratio = 0.3
        density = 1000.0
    """
    own = sf.Case.from_toml(text, tmp_path)
    page = tmp_path / "case.toml"
    page.write_text(text)
    given = sf.Case(page, mesh=own.mesh)
    assert own.solver().base.forces.sum() == pytest.approx(-1e-3)
    assert np.array_equal(given.solver().base.forces, own.solver().base.forces)


def test_a_half_model_has_no_gravity_across_its_plane() -> None:
    box = sf.Mesh.box((0.05, 0.01, 0.01), (3, 1, 1))
    half = sf.Mesh(box.nodes, box.elements, half=True)
    case = {"gravity": [0.0, 0.0, -9.81], "region": [RUBBER], "clamp": [{"plane": {"x": 0.0}}], "static": {"levels": [1.0]}}
    with pytest.raises(sf.CaseError, match="gravity"):
        sf.Case(case, mesh=half).solver()




def cuboid(path: Path, size: tuple[float, float, float]) -> None:
    """An STL of a box, mm."""
    faces = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5)]
    corners = [[size[axis] * (corner >> axis & 1) for axis in range(3)] for corner in range(8)]
    loops = ["".join("vertex {} {} {}\n".format(*corners[corner]) for corner in face) for face in faces]
    body = "".join(f"facet normal 0 0 0\nouter loop\n{loop}endloop\nendfacet\n" for loop in loops)
    path.write_text(f"solid box\n{body}endsolid box\n")


@pytest.mark.parametrize("elements, corners", [("tetrahedra", 10), ("hexahedra", 20), ("auto", 20)])
def test_elements_of_a_surface_mean_what_they_mean_to_the_command_line(tmp_path: Path, elements: str, corners: int) -> None:
    cuboid(tmp_path / "box.stl", (40.0, 10.0, 20.0))
    page = tmp_path / "case.toml"
    page.write_text(f"""
        mesh = {{ body = "box.stl", edge = 0.01, unit = "mm", elements = "{elements}" }}
        clamp = [{{ plane = {{ x = 0.0 }} }}]
        load = [{{ plane = {{ x = 0.04 }}, traction = [0.0, -10.0, 0.0] }}]
        static = {{ levels = [1.0] }}
        output = {{ vtu_every = 1 }}
        [[region]]
        material = "neo_hookean"
        youngs_modulus = 2e5
        poissons_ratio = 0.4
        density = 1000.0
    """)
    case = sf.Case(page)
    frames, body = written(case.run(tmp_path / "out")), case.solver()
    assert body.mesh.elements.shape[1] == corners
    assert np.abs(frames[-1] - body.equilibrium().displacement).max() <= 1e-12 < np.abs(frames).max()
