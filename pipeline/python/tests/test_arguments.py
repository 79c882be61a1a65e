"""Every argument has an effect or is refused; what the package offers is what it says."""

from __future__ import annotations

import copy
import dataclasses
import inspect
import pickle
import pydoc
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import softfish as sf
from conftest import EXAMPLES, hollow


def beam() -> sf.Solver:
    """A body without a case."""
    mesh = sf.Mesh.box((0.05, 0.01, 0.01), (4, 1, 1))
    return sf.Solver.of_mesh(mesh, sf.Material(2e5, 0.4), mesh.nodes[:, 0] == 0.0)


@pytest.mark.parametrize("call, word", [
    (lambda b: b.equilibrium(E=1e5, inputs=b.inputs()), "E"),
    (lambda b: b.equilibrium(gravity=[0, 0, 0], inputs=b.inputs()), "gravity"),
    (lambda b: b.equilibrium(E=1e5, element_E=np.full(len(b.element_regions), 1e5)), "element_E"),
    (lambda b: b.simulate(3, 1e-3, E=1e5, inputs=b.inputs()), "E"),
    (lambda b: b.simulate(1.9, 1e-3), "steps"),
    (lambda b: b.simulate(3, 1e-3, progress=5), "progress"),
    (lambda b: b.simulate(3, 1e-3, scheme="rk4"), "scheme"),
    (lambda b: b.simulate(3, 1e-3, memory=1e9), "memory"),
    (lambda b: b.simulate(3, -1e-3), "step"),
    (lambda b: b.simulate(3, 1e-3, initial=np.zeros((2, 3))), "initial"),
    (lambda b: b.simulate(3, 1e-3, pressure={"air": [1.0, 2.0]}), "air"),
    (lambda b: b.equilibrium(load_steps=2.5), "load_steps"),
    (lambda b: b.equilibrium(reuse_factor=True), "reuse_factor"),
    (lambda b: b.equilibrium(reuse_factor="yes", initial_guess=np.zeros(b.mesh.nodes.shape)), "reuse_factor"),
    (lambda b: b.equilibrium(level="full"), "level"),
    (lambda b: b.equilibrium(inputs={"E": 1e5}), "inputs"),
    (lambda b: b.equilibrium(inputs=dataclasses.replace(b.inputs(), forces=np.zeros((2, 3)))), "inputs"),
    (lambda b: b.equilibrium(E=np.float16(6e4)), "half"),
    (lambda b: b.equilibrium().modes(2.5), "count"),
    (lambda b: b.equilibrium().modes(0), "count"),
    (lambda b: b.equilibrium().chamber(True), "chamber"),
    (lambda b: b.equilibrium().chamber(-1), "chamber"),
    (lambda b: b.reduce(np.ones((2, *b.mesh.nodes.shape)), 2.5), "coordinates"),
    (lambda b: b.reduce(np.ones((2, *b.mesh.nodes.shape)), 2, tolerance=0.0), "tolerance"),
    (lambda b: sf.Solver.of_mesh(b.mesh, "rubber", [0]), "materials"),
    (lambda b: sf.Solver.of_mesh(b.mesh, {"region_0": 3}, [0]), "materials"),
    (lambda b: sf.Solver.of_mesh(b.mesh, sf.Material(2e5, 0.4, law="steel"), [0]), "law"),
    (lambda b: sf.Solver.of_mesh(b.mesh, sf.Material(2e5, 0.4, mean_dilatation=2), [0]), "mean_dilatation"),
    (lambda b: sf.Solver.of_mesh(b.mesh, sf.Material(2e5, 0.4), b.mesh.nodes[:, 0] == 0, lumped_mass="no"), "lumped_mass"),
    (lambda b: sf.Solver.of_mesh(b.mesh, sf.Material(2e5, 0.4), b.mesh.nodes[:, 0] == 0, threads=0), "threads"),
    (lambda b: sf.Case({"region": []}, mesh="finger.msh"), "mesh"),
    (lambda b: sf.Case(EXAMPLES / "cantilever.toml", mesh=b.mesh).run(), "mesh"),
    (lambda b: sf.Solver(b.mesh), "case"),
    (lambda b: b.equilibria(), "levels"),
    (lambda b: b.path(), "path"),
    (lambda b: beam().equilibrium(level=0.5, gravity=[0, 0, -9.81]), "level"),
    (lambda b: beam().inputs(level=0.5), "level"),
    (lambda b: b.equilibrium(level=0.5, pressure={"air": 1e3}, forces=np.ones(b.mesh.nodes.shape)), "level"),
    (lambda b: b.simulate(3, 1e-3, scheme="quasi_static", mass_damping=1.0), "mass_damping"),
    (lambda b: b.simulate(3, 1e-3, scheme="quasi_static", stiffness_damping=1.0), "stiffness_damping"),
    (lambda b: b.simulate(3, 1e-3, scheme="quasi_static", initial=(np.zeros(b.mesh.nodes.shape), 1.0 * (b.mesh.nodes > 0.01))), "initial[1]"),
    (lambda b: b.simulate(3, 1e-3, initial=(np.ones(b.mesh.nodes.shape), np.zeros(b.mesh.nodes.shape))), "clamped"),
    (lambda b: b.simulate(3, 1e-3, pressure={"air": 1e3, 0: 2e3}), "twice"),
    (lambda b: b.simulate(3, 1e-3, mass_damping=-1.0), "mass_damping"),
    (lambda b: b.equilibrium(tolerance=0.1), "tolerance"),
    (lambda b: b.equilibrium().output("marker.node.tip"), "marker.node.tip"),
    (lambda b: b.observe("marker.nose", b.mesh.nodes), "nose"),
    (lambda b: sf.Equilibrium(), "by hand"),
    (lambda b: sf.Motion(b), "Motion"),
    (lambda b: sf.Path(), "by hand"),
    (lambda b: sf.ReducedModel(b, None), "core"),
    (lambda b: sf.ReducedState([1.0, 2.0], [1.0]), "velocity"),
    (lambda b: sf.Material("soft", 0.4), "youngs_modulus"),
    (lambda b: sf.Material(2e5), "poissons_ratio"),
    (lambda b: dataclasses.replace(b.inputs(), level="full"), "level"),
    (lambda b: setattr(b, "mesh", None), "mesh"),
    (lambda b: setattr(b, "tolerance", 1e-3), "tolerance"),
    (lambda b: setattr(b.mesh, "nodes", b.mesh.nodes), "nodes"),
    (lambda b: setattr(b.equilibrium(), "displacement", 2.0 * b.mesh.nodes), "displacement"),
    (lambda b: sf.track("a.mp4", at=[[1.0, 2.0]], region=[0, 0, 9, 9]), "region"),
    (lambda b: sf.Record("nowhere"), "nowhere"),
    (lambda b: b.equilibrium(E=np.ma.array([2e5], mask=[True])), "`E` has masked"),
    (lambda b: sf.Mesh(np.ma.array(b.mesh.nodes, mask=b.mesh.nodes > 0.01), b.mesh.elements), "`nodes` has masked"),
])
def test_an_argument_without_effect_or_sense_is_refused_by_its_name(block: sf.Solver, call, word: str) -> None:
    with pytest.raises(sf.InputError) as caught:
        call(block)
    error = caught.value
    assert word in str(error) and error.what and error.why and error.action


def test_inputs_and_results_are_read_only(block: sf.Solver) -> None:
    found, motion = block.equilibrium(), block.simulate(2)
    inputs = block.inputs()
    arrays = [block.mesh.nodes, block.mesh.elements, block.mesh.regions, block.mesh.skin, block.mesh.numbering, block.element_regions]
    arrays += [block.base.forces, block.base.gravity, block.base.youngs_modulus, inputs.density, found.displacement, found.pressures]
    for array in [*arrays, motion.displacement, motion.times, motion.pressures]:
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0
    given = np.zeros(block.mesh.nodes.shape)
    kept = block.inputs(forces=given)
    given[:] = 1.0
    assert np.all(kept.forces == 0.0)


def test_a_scale_of_moduli_is_positive(block: sf.Solver) -> None:
    shapes = np.stack([block.equilibrium(pressure=p).displacement for p in (1e3, 3e3)])
    model = block.reduce(shapes, 2)
    for scale in ([0.0], [-1.0], [np.nan], [1.0, 1.0]):
        with pytest.raises(sf.InputError, match="modulus_scale"):
            model.step(model.rest(), {"air": 1e3}, modulus_scale=scale)
    with pytest.raises(sf.InputError, match="dt"):
        model.step(model.rest(), {"air": 1e3}, 0.0)


def copies(thing):
    return [pickle.loads(pickle.dumps(thing)), copy.deepcopy(thing)]


def test_everything_can_be_copied(block: sf.Solver, tmp_path: Path) -> None:
    found, motion = block.equilibrium(), block.simulate(3)
    slope = np.ones_like(found.displacement)
    for again in copies(found):
        assert np.array_equal(again.displacement, found.displacement) and not again.displacement.flags.writeable
        assert np.allclose(again.adjoint(slope).youngs_modulus, found.adjoint(slope).youngs_modulus, rtol=1e-7)
    for again in copies(motion):
        assert np.array_equal(again.velocity, motion.velocity)
        ones = np.ones_like(motion.displacement)
        assert np.allclose(again.adjoint(ones).density, motion.adjoint(ones).density, rtol=1e-6)
    for again in copies(block):
        assert repr(again) == repr(block) and np.array_equal(again.equilibrium().displacement, block.equilibrium().displacement)
    for again in copies(block.inputs(E=3e5)):
        assert again.youngs_modulus[0] == 3e5 and not again.youngs_modulus.flags.writeable
    model = block.reduce(np.stack([found.displacement, 0.5 * found.displacement**2]), 2)
    state = model.step(model.rest(), {"air": 1e3})
    for again in copies(model):
        assert np.array_equal(again.step(again.rest(), {"air": 1e3}).coordinates, state.coordinates)
    case = sf.Case(EXAMPLES / "finger.toml")
    for again in copies(case):
        assert again.path == case.path and np.array_equal(again.mesh.nodes, case.mesh.nodes)
    page = tmp_path / "moved.toml"
    page.write_text((EXAMPLES / "cantilever.toml").read_text().replace("cantilever.msh", (EXAMPLES / "cantilever.msh").as_posix()))
    moved = sf.Case(page)
    data = pickle.dumps(moved)
    page.unlink()
    assert pickle.loads(data).solver().levels == [0.1, 1.0]
    brick = sf.Solver.of_mesh(hollow(), sf.Material(2e5, 0.4), hollow().nodes[:, 0] == 0.0, threads=1)
    weight = [0.0, 0.0, -9.81]
    for again in copies(brick):
        assert np.array_equal(again.equilibrium(gravity=weight).displacement, brick.equilibrium(gravity=weight).displacement)
    path = sf.Case(EXAMPLES / "column.toml").solver
    assert callable(path)
    with pytest.raises(sf.ConvergenceError) as caught:
        block.equilibrium(pressure=9e6)
    for again in copies(caught.value):
        assert (again.what, again.level) == (caught.value.what, caught.value.level)


def test_reprs_say_sizes(block: sf.Solver) -> None:
    said = {
        repr(block.mesh): ["96 nodes", "252 tetrahedra of 4", "1 chamber"],
        repr(block): ["96 nodes", "252 elements", "dofs", "air", "tip"],
        repr(block.equilibrium()): ["96 nodes", "iterations"],
        repr(block.simulate(2)): ["2 steps", "96 nodes"],
        repr(sf.Case(EXAMPLES / "finger.toml")): ["finger.toml", "2 regions", "1 chamber", "4 levels"],
    }
    for text, words in said.items():
        assert all(word in text for word in words), text


def test_the_package_offers_what_it_lists() -> None:
    assert sf.__version__.count(".") == 2
    listed = dir(sf)
    assert "Mesh" in listed and "np" not in listed and "annotations" not in listed
    assert all(hasattr(sf, name) for name in sf.__all__)
    for thing in (getattr(sf, name) for name in sf.__all__ if name not in ("MATERIALS",)):
        assert thing.__doc__, thing
        if isinstance(thing, type):
            for name in getattr(thing, "__annotations__", {}):
                assert name.startswith("_") or f"{name}: " in thing.__doc__, f"{thing.__name__}.{name}"
            for name, member in vars(thing).items():
                if not name.startswith("_") and (callable(member) or isinstance(member, property | classmethod | staticmethod)):
                    assert member.__doc__ or dataclasses.is_dataclass(thing), f"{thing.__name__}.{name}"


UNIT = re.compile(r"(?<![A-Za-z])(Pa|m|m/s²?|s|s/m|N|N/m|J|kg|kg/m³|Hz|px²?|grey levels a pixel|SI units|no unit)(?![A-Za-z])")
SHAPE = re.compile(r"×|[Bb]y (region|element|chamber)|[Oo]ne (per|a) |[Oo]f each|x, y and z|of the regions|(each|For each) (element|node|point|view|step|tangent)|chambers")


def attributes(thing: type) -> Iterator[tuple[str, str, str]]:
    """Name, type and description of each attribute and property of a class."""
    for name, kind in getattr(thing, "__annotations__", {}).items():
        entry = re.search(rf"^\s+{name}: (.*?)(?=^\s+\w+: |\Z)", thing.__doc__ or "", re.MULTILINE | re.DOTALL)
        if not name.startswith("_"):
            yield name, str(kind), " ".join(entry.group(1).split()) if entry else ""
    for name, member in vars(thing).items():
        if isinstance(member, property) and not name.startswith("_") and member.fget is not None:
            yield name, str(member.fget.__annotations__["return"]), member.__doc__ or ""


def test_every_number_of_a_class_is_described_with_its_shape_and_unit() -> None:
    counted = 0
    for thing in (getattr(sf, name) for name in sf.__all__):
        for name, kind, text in attributes(thing) if isinstance(thing, type) else ():
            of = f"{thing.__name__}.{name}: {text}"
            counts = "IntArray" in kind or "int64" in kind or "bool" in kind
            if "Array" in kind or "float" in kind:
                counted += 1
                assert counts or UNIT.search(text), of
            if "Array" in kind and "dict" not in kind:
                assert SHAPE.search(text), of
    assert counted > 40
    assert "no unit" in pydoc.render_doc(sf.Gradient, renderer=pydoc.plaintext)


@pytest.mark.parametrize("absent", ["torch", "jax"])
def test_the_package_can_be_imported_whole_without_optional_packages(absent: str) -> None:
    program = f"""
import importlib.util, sys
find = importlib.util.find_spec
importlib.util.find_spec = lambda name, package=None: None if name == "{absent}" else find(name, package)
sys.modules["{absent}"] = None
import softfish
names = {{"torch": "TorchFunction", "jax": "JaxFunction"}}
assert not hasattr(softfish, names["{absent}"])
exec("from softfish import *")
assert "Mesh" in globals() and names["{absent}"] not in globals()
try:
    getattr(softfish, names["{absent}"])
except softfish.Error as error:
    print(error.what, error.action)
"""
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    assert ran.returncode == 0 and f"pip install {absent}" in ran.stdout, ran.stderr[-800:]


def test_one_layer_checks_an_argument_wherever_it_stands(block: sf.Solver) -> None:
    from softfish._arguments import CHECKS

    calls = [sf.track, sf.calibrate, sf.fit, sf.Case.run, sf.Case.solver, sf.Mesh.read, sf.Mesh.from_stl, sf.Mesh.from_meshio, sf.Mesh, sf.Project]
    calls += [getattr(sf.Solver, name) for name in ("equilibrium", "equilibria", "path", "simulate", "inputs", "modes", "of_mesh")]
    calls += [getattr(sf.ReducedModel, name) for name in ("step", "step_gradient", "torch_step", "jax_step", "save", "load")]
    good = {"body": "a", "columns": 5, "edge": 0.01, "film": "a", "page": "a", "path": "a", "rows": 4, "source": "a", "square": 0.01}
    counted = 0
    for call in calls:
        parameters = inspect.signature(call).parameters
        required = {name: good.get(name) for name, one in parameters.items() if one.default is one.empty}
        for name in parameters.keys() & CHECKS.keys():
            counted += 1
            with pytest.raises(sf.InputError) as caught:
                call(**{**required, name: object()})
            assert f"`{name}`" in caught.value.what and caught.value.why and caught.value.action, (call, name)
    assert counted > 60
    for wrong, word in (({"presure": 1e3}, "`pressure`"), ({"pressures": 1e3}, "`pressure`"), ({"colour": 1}, "correct the call")):
        with pytest.raises(sf.ArgumentError, match="equilibrium") as unfit:
            block.equilibrium(**wrong)
        assert isinstance(unfit.value, TypeError) and word in unfit.value.action
    with pytest.raises(sf.ArgumentError, match="dloss_du"):
        block.adjoint(block.equilibrium())


def test_a_copy_of_a_mesh_keeps_what_became_of_the_callers_nodes() -> None:
    box = sf.Mesh.box((0.05, 0.01, 0.01), (4, 1, 1))
    dropped = sf.Mesh(np.vstack([[[0.02, 0.02, 0.02]], box.nodes]), box.elements + 1)
    for again in copies(dropped):
        assert np.array_equal(again.numbering, dropped.numbering) and again.notes == dropped.notes
        with pytest.raises(sf.InputError, match="node numbers"):
            sf.Solver.of_mesh(again, sf.Material(2e5, 0.4), [1, 2, 3])
