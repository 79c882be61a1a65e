"""Bad input: an exception that says what, why and what to do, never an abort."""

from __future__ import annotations

import numpy as np
import pytest

import softfish as sf

BAD = [np.nan, np.inf, -1.0, "soft", None, [], [1.0, 2.0], np.zeros((2, 2)), 1e300, -1e300, 1j, True, {"nowhere": 1.0}, object()]


def test_two_hundred_bad_calls_raise_or_return_and_never_abort(block: sf.Solver) -> None:
    generator = np.random.default_rng(11)
    names = ["E", "nu", "density", "pressure", "element_E", "forces", "gravity", "initial_guess", "tolerance", "load_steps"]
    refused = 0
    for _ in range(200):
        chosen = generator.choice(names, size=2, replace=False)
        arguments = {str(name): BAD[generator.integers(len(BAD))] for name in chosen}
        try:
            block.equilibrium(**arguments)
        except (sf.Error, TypeError, ValueError) as error:
            refused += 1
            assert str(error)
    assert refused > 100
    assert np.isfinite(block.equilibrium().displacement).all()


@pytest.mark.parametrize("arguments, word", [
    ({"E": -1.0}, "Young's modulus"),
    ({"nu": 0.5}, "Poisson's ratio"),
    ({"E": {"nowhere": 1.0}}, "there is no region"),
    ({"pressure": {"nowhere": 1.0}}, "there is no chamber"),
    ({"forces": np.zeros((3, 3))}, "shape"),
    ({"gravity": [0.0, np.nan, 0.0]}, "not finite"),
    ({"E": np.array(["a"])}, "holds <U1"),
    ({"element_E": np.full(3, 1e5)}, "shape"),
    ({"tolerance": 2.0}, "tolerance"),
])
def test_each_refusal_says_what_why_and_what_to_do(block: sf.Solver, arguments: dict, word: str) -> None:
    with pytest.raises(sf.InputError, match=word) as caught:
        block.equilibrium(**arguments)
    assert caught.value.what and caught.value.why and caught.value.action


def test_elements_with_negative_moduli_are_refused_and_the_next_solve_works(block: sf.Solver) -> None:
    moduli = np.full(len(block.element_regions), 2e5)
    moduli[7] = -1.0
    with pytest.raises(sf.InputError, match="element 7"):
        block.equilibrium(element_E=moduli)
    block.equilibrium()


def test_a_body_that_finds_no_equilibrium_says_so_and_can_be_used_again(block: sf.Solver) -> None:
    with pytest.raises(sf.ConvergenceError, match="no equilibrium"):
        block.equilibrium(pressure=9e6)
    assert np.isfinite(block.equilibrium().displacement).all()


@pytest.mark.parametrize("make", [
    lambda: sf.Mesh([[0.0, 0, 0]], [[0, 1, 2, 3]]),
    lambda: sf.Mesh(np.eye(4, 3), [[0, 1, 2]]),
    lambda: sf.Mesh(np.full((4, 3), np.nan), [[0, 1, 2, 3]]),
    lambda: sf.Mesh(np.eye(4, 3), [[0.0, 1.0, 2.0, 3.0]]),
    lambda: sf.Mesh(np.eye(4, 3), [[-1, 1, 2, 3]]),
    lambda: sf.Mesh.read("nowhere.msh"),
    lambda: sf.Mesh.read("nowhere.xyz"),
    lambda: sf.Mesh.box((1.0, 1.0, 0.0), (1, 1, 1)),
    lambda: sf.Case("nowhere.toml"),
    lambda: sf.Case({"mesh": {"file": "a.msh"}, "regin": []}),
    lambda: sf.Case({"region": [object()]}),
    lambda: sf.Case.from_toml("= 3"),
])
def test_meshes_and_cases_that_make_no_sense_are_refused(make) -> None:
    with pytest.raises(sf.InputError) as caught:
        make()
    assert caught.value.what and caught.value.why


def test_a_body_that_can_move_freely_is_refused() -> None:
    mesh = sf.Mesh.box((0.1, 0.02, 0.02), (3, 1, 1))
    with pytest.raises(sf.InputError, match="not sufficiently constrained"):
        sf.Solver.of_mesh(mesh, sf.Material(2e5, 0.4), [0])


@pytest.mark.parametrize("output, wrt", [("marker.nose", ["E.region_0"]), ("marker.tip", ["E.bone"]), ("marker.tip", [])])
def test_functions_of_unknown_names_are_refused(block: sf.Solver, output: str, wrt: list[str]) -> None:
    pytest.importorskip("torch")
    with pytest.raises(sf.InputError):
        block.torch(output, wrt)
