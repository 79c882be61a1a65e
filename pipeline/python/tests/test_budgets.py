"""No call without an end: budgets, Ctrl-C, forks, sizes."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import softfish as sf
from conftest import EXAMPLES, hollow


@pytest.mark.parametrize("E, pressure", [(1.6e5, -2e4), (1.6e5, 1e5)])
def test_a_load_that_cannot_be_carried_ends_by_itself_with_the_last_equilibrium(finger: sf.Solver, E: float, pressure: float) -> None:
    began = time.monotonic()
    with pytest.raises(sf.ConvergenceError) as caught:
        finger.equilibrium(E={"silicone": E}, pressure=pressure, max_iterations=60)
    assert time.monotonic() - began < 20.0
    error = caught.value
    assert isinstance(error, sf.BudgetError) and "60 Newton iterations" in error.why and "max_iterations" in error.why
    assert error.level is not None and 0.0 < error.level < 1.0 and error.equilibrium is not None
    assert error.equilibrium.level == error.level
    assert error.equilibrium.pressures[0] == pytest.approx(error.level * pressure)
    again = finger.equilibrium(E={"silicone": E}, pressure=error.equilibrium.pressures, initial_guess=error.equilibrium.displacement)
    assert np.abs(again.displacement - error.equilibrium.displacement).max() < 1e-4


def test_the_default_ends_ten_times_the_buckling_load_within_twenty_seconds(finger: sf.Solver) -> None:
    began = time.process_time()
    with pytest.raises(sf.ConvergenceError):
        finger.equilibrium(pressure=-8e4)
    assert time.process_time() - began < 20.0


def test_cut_backs_and_seconds_are_limits_as_well(finger: sf.Solver) -> None:
    with pytest.raises(sf.ConvergenceError, match="no equilibrium") as few:
        finger.equilibrium(pressure=1e5, max_cutbacks=0, load_steps=1)
    assert not isinstance(few.value, sf.BudgetError)
    began = time.monotonic()
    with pytest.raises(sf.BudgetError, match="timeout"):
        finger.equilibrium(pressure=1e5, timeout=0.5, max_iterations=10**6)
    assert time.monotonic() - began < 5.0


def test_keys_of_a_case_and_options_of_a_run_are_the_same_limits(tmp_path: Path) -> None:
    text = (EXAMPLES / "finger.toml").read_text().replace("finger.msh", (EXAMPLES / "finger.msh").as_posix())
    page = tmp_path / "far.toml"
    page.write_text(text.replace("pressure = 8.0e3", "pressure = 8.0e5").replace("[static]", "[static]\nmax_iterations = 30"))
    case = sf.Case(page)
    with pytest.raises(sf.BudgetError, match="30 Newton iterations"):
        case.run(tmp_path / "out")
    with pytest.raises(sf.BudgetError, match="30 Newton iterations"):
        case.solver().equilibria()
    with pytest.raises(sf.BudgetError, match="12 Newton iterations"):
        case.run(tmp_path / "out", max_iterations=12)


def test_a_motion_keeps_its_last_time_and_shape(block: sf.Solver) -> None:
    with pytest.raises(sf.BudgetError) as caught:
        block.simulate(1000, 1e-4, timeout=0.05)
    assert caught.value.time is not None and caught.value.time > 0.0
    assert caught.value.displacement is not None and caught.value.displacement.shape == block.mesh.nodes.shape


def test_a_search_for_modes_ends_at_its_limit_and_the_solver_is_free() -> None:
    mesh = sf.Mesh.box((0.1, 0.02, 0.02), (10, 4, 4))
    body = sf.Solver.of_mesh(mesh, sf.Material(2e5, 0.45), mesh.nodes[:, 0] == 0.0)
    rest = body.equilibrium(gravity=[0.0, 0.0, -0.1])
    with pytest.raises(sf.BudgetError, match="100 modes") as caught:
        rest.modes(100, timeout=0.5)
    assert "timeout" in caught.value.why and ended(lambda: rest.modes(200)) < 1.0
    assert rest.modes(2, timeout=60.0)[0][0] > 0.0


@pytest.mark.parametrize("limit", [{"max_iterations": 0}, {"max_iterations": 1.5}, {"max_cutbacks": -1}, {"timeout": 0.0}, {"timeout": "long"}])
def test_limits_are_checked(block: sf.Solver, limit: dict) -> None:
    with pytest.raises(sf.InputError, match=next(iter(limit))):
        block.equilibrium(**limit)


def ended(call, after: float = 0.6) -> float:
    """Seconds from Ctrl-C until the call returns."""
    timer = threading.Timer(after, os.kill, (os.getpid(), signal.SIGINT))
    began = time.monotonic()
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        call()
    timer.join()
    return time.monotonic() - began - after


def test_a_reduction_and_a_solver_hear_ctrl_c_within_a_second_and_can_be_used_again() -> None:
    mesh = sf.Mesh.box((0.1, 0.02, 0.02), (30, 6, 6))
    body = sf.Solver.of_mesh(mesh, sf.Material(2e5, 0.45, 1000.0), mesh.nodes[:, 0] == 0.0)
    shapes = np.random.default_rng(0).standard_normal((30, *mesh.nodes.shape)) * 1e-5
    assert ended(lambda: body.reduce(shapes, 30, tolerance=1e-9)) < 1.0
    assert ended(lambda: [body.equilibrium(gravity=[0.0, 0.0, -9.81 * k]) for k in range(1, 100)]) < 1.0
    assert np.isfinite(body.equilibrium(gravity=[0.0, 0.0, -0.1]).displacement).all()


def test_snapshots_without_a_shape_are_refused(block: sf.Solver) -> None:
    shape = (3, *block.mesh.nodes.shape)
    clamped = np.zeros(shape)
    clamped[:, block.mesh.nodes[:, 0] == 0.0] = 1e-3
    for shapes in (np.zeros(shape), clamped, np.full(shape, 1e-200), np.full(shape, 1e200)):
        with pytest.raises(sf.InputError, match="snapshots"):
            block.reduce(shapes)


def test_a_panic_is_a_typed_error(block: sf.Solver) -> None:
    found = block.equilibrium()
    model = block.reduce(np.stack([found.displacement]), 1)
    with pytest.raises(sf.InternalError) as caught:
        model._core.chamber_volume(np.zeros(1), 99)
    assert "index out of bounds" in caught.value.why and caught.value.action
    assert np.isfinite(block.equilibrium().displacement).all()


def _solve(body: sf.Solver, queue: multiprocessing.Queue) -> None:
    queue.put(body.equilibrium().displacement.sum())


@pytest.mark.skipif(not hasattr(os, "fork"), reason="forks are of Unix")
@pytest.mark.parametrize("threads", [None, 1, 2])
def test_a_solver_made_before_a_fork_solves_in_the_child(threads: int | None) -> None:
    case = {
        "gravity": [0.0, 0.0, -9.81],
        "region": [{"material": "neo_hookean", "youngs_modulus": 2e5, "poissons_ratio": 0.4, "density": 1000.0}],
        "clamp": [{"plane": {"x": 0.0}}],
        "static": {"levels": [1.0]},
    }
    body = sf.Case(case, mesh=hollow()).solver(threads=threads)
    mine = body.equilibrium().displacement.sum()
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    child = context.Process(target=_solve, args=(body, queue))
    child.start()
    try:
        assert queue.get(timeout=20.0) == pytest.approx(mine, rel=1e-9)
    finally:
        child.kill()
        child.join()


@pytest.mark.skipif(sys.platform != "linux", reason="limits of memory are read from /proc")
@pytest.mark.parametrize("call", [
    'sf.Mesh.box((1.0, 1.0, 1.0), (100, 100, 100))',
    'body.simulate(10_000_000, 1e-3)',
    'body.reduce(np.ones((200, *body.mesh.nodes.shape)), 1000)',
])
def test_what_does_not_fit_into_memory_is_refused_before_it_is_taken(call: str) -> None:
    program = f"""
import resource, numpy as np, softfish as sf
mesh = sf.Mesh.box((0.1, 0.02, 0.02), (10, 4, 4))
body = sf.Solver.of_mesh(mesh, sf.Material(2e5, 0.45), mesh.nodes[:, 0] == 0.0)
resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))
try:
    {call}
except sf.InputError as error:
    print("refused:", error.what, error.why)
"""
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    assert ran.returncode == 0 and "refused:" in ran.stdout and "GB" in ran.stdout, (ran.stdout, ran.stderr[-500:])
