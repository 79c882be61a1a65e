"""Derivatives of JAX against differences: at rest and in ten steps of motion."""

from __future__ import annotations

import numpy as np
import pytest

import softfish as sf

jax = pytest.importorskip("jax")
jax.config.update("jax_enable_x64", True)
jnp = jax.numpy
test_util = pytest.importorskip("jax.test_util")

CASES = [("E.region_0", 2e5, 1.0), ("nu.region_0", 1.0, 0.4), ("pressure.air", 5e3, 1.0)]


@pytest.mark.parametrize("wrt, factor, at", CASES)
def test_derivatives_at_rest_pass_check_grads(block: sf.Solver, wrt: str, factor: float, at: float) -> None:
    function = block.jax("marker.tip", [wrt])
    test_util.check_grads(lambda x: 1e3 * function(factor * x), (at,), 1, atol=1e-6, rtol=1e-6, eps=1e-5)


def test_derivatives_by_elements_and_forces_pass_check_grads(brick: sf.Solver) -> None:
    generator = np.random.default_rng(1)
    moduli = generator.uniform(0.8, 1.2, len(brick.element_regions))
    forces = generator.normal(size=brick.mesh.nodes.shape)
    pick = generator.normal(size=brick.mesh.nodes.shape)
    for steps in ({}, {"steps": 10, "step": 2e-3}):
        function = brick.jax("displacement", ["element_E", "force"], **steps)
        call = lambda E, f: 1e3 * jnp.sum(pick * function(2e5 * E, 1e-4 * f))  # noqa: E731
        test_util.check_grads(call, (moduli, forces), 1, ["rev"], atol=1e-5, rtol=1e-6, eps=1e-5)


@pytest.mark.parametrize("wrt, factor, at", CASES)
def test_derivatives_of_ten_steps_pass_check_grads(block: sf.Solver, wrt: str, factor: float, at: float) -> None:
    function = block.jax("marker.tip", [wrt], steps=10)
    start = np.linspace(0.2, at, 10) if wrt.startswith("pressure") else at
    test_util.check_grads(lambda x: 1e3 * function(factor * x), (start,), 1, ["rev"], atol=1e-6, rtol=1e-6, eps=1e-5)


def test_jit_vmap_and_grad_go_together(block: sf.Solver) -> None:
    function = block.jax("marker.tip", ["E.region_0", "pressure.air"])
    loss = lambda E, p: jnp.sum(function(E, p) ** 2)  # noqa: E731
    moduli = jnp.array([1.5e5, 2e5, 3e5])
    together = jax.jit(jax.vmap(jax.grad(loss), in_axes=(0, None)))(moduli, 4e3)
    singles = jnp.array([jax.grad(loss)(E, 4e3) for E in moduli])
    assert np.allclose(together, singles, rtol=1e-7)


def test_the_backward_pass_finds_the_result_of_its_forward_solve(block: sf.Solver) -> None:
    function = block.jax("marker.tip", ["E.region_0"])
    solves = []
    solve = function.function.solve
    function.function.solve = lambda values: solves.append(1) or solve(values)
    jax.grad(lambda E: jnp.sum(function(E)))(2e5)
    jax.jit(jax.grad(lambda E: jnp.sum(function(E))))(2.1e5)
    assert len(solves) == 2


def test_a_failed_solve_raises_outside_of_the_callback(block: sf.Solver) -> None:
    function = block.jax("marker.tip", ["pressure.air"])
    with pytest.raises(sf.ConvergenceError):
        function(9e6)
    assert np.isnan(jax.jit(lambda p: function(p))(9e6)).all()
    with pytest.raises(sf.ConvergenceError):
        function.check()
    assert np.isfinite(function(1e3)).all()
