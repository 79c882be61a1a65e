"""Steps of a reduced model in JAX: those of numpy, in scans, batches and compiled, with the gradient of differences."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import softfish as sf

jax = pytest.importorskip("jax")
jax.config.update("jax_enable_x64", True)
jnp = jax.numpy
test_util = pytest.importorskip("jax.test_util")
DT = 2e-3


@pytest.fixture
def model(block: sf.Solver) -> sf.ReducedModel:
    shapes = [block.equilibrium(pressure={"air": p}, gravity=[0.0, 0.0, g]).displacement for p in (1e3, 4e3, 8e3) for g in (20.0, -20.0)]
    return block.reduce(shapes, 6)


def rollout(model: sf.ReducedModel, step):
    """1000 times the last marker's place as a function of pressures over 5 kPa."""
    rows, rest = jnp.asarray(model.output_rows("marker.tip")), jnp.zeros(model.coordinates)

    def advance(state, pressure):
        state = step(*state, 5e3 * pressure[None])
        return state, rows @ state[0]

    return lambda history: 1e3 * jax.lax.scan(advance, (rest, rest), history)[1][-1]


def test_steps_are_those_of_numpy(model: sf.ReducedModel) -> None:
    step = model.jax_step(DT, stiffness_damping=1e-3)
    state = model.rest()
    q, v = state.coordinates, state.velocity
    for pressure in (1e3, 3e3, 5e3):
        state = model.step(state, {"air": pressure}, DT, stiffness_damping=1e-3)
        q, v = step(q, v, [pressure])
    assert np.array_equal(q, state.coordinates) and np.array_equal(v, state.velocity)
    for again in (copy.deepcopy(step), pickle.loads(pickle.dumps(step))):
        assert np.array_equal(again(q, v, [2e3])[0], step(q, v, [2e3])[0])


def test_a_scan_of_steps_passes_check_grads(model: sf.ReducedModel) -> None:
    value = rollout(model, model.jax_step(DT, stiffness_damping=1e-3))
    test_util.check_grads(value, (jnp.linspace(0.2, 1.0, 6),), 1, atol=1e-5, rtol=1e-5, eps=1e-4)
    test_util.check_grads(jax.jit(value), (jnp.linspace(0.2, 1.0, 6),), 1, atol=1e-5, rtol=1e-5, eps=1e-4)


def test_a_batch_is_the_cases_one_after_the_other(model: sf.ReducedModel) -> None:
    slope = jax.jit(jax.grad(lambda history: jnp.sum(rollout(model, model.jax_step(DT))(history) ** 2)))
    histories = jnp.array([[0.2, 0.4, 0.6], [1.0, 0.8, 0.6]])
    together = jax.vmap(slope)(histories)
    assert np.allclose(together, [slope(history) for history in histories], rtol=1e-9)


def test_what_a_step_does_not_have_is_refused(model: sf.ReducedModel) -> None:
    step, zero = model.jax_step(DT), jnp.zeros(model.coordinates)
    total = lambda p: jnp.sum(step(zero, zero, p)[0])  # noqa: E731
    p = jnp.array([3e3])
    for call in (lambda: jax.hessian(total)(p), lambda: jax.jacrev(jax.grad(total))(p)):
        with pytest.raises(sf.DerivativeError) as caught:
            call()
        assert caught.value.why and caught.value.action
    for wrong in ((zero[:2], zero, p), (zero, zero, jnp.zeros(3)), (zero, zero, jnp.zeros(1, dtype=jnp.complex64))):
        with pytest.raises(sf.InputError):
            step(*wrong)
    for settings in ({"dt": 0.0}, {"modulus_scale": [0.0]}, {"mass_damping": "much"}):
        with pytest.raises(sf.InputError):
            model.jax_step(**settings)


def test_a_step_that_fails_in_compiled_code_is_nan_and_raises_afterwards(model: sf.ReducedModel) -> None:
    step, zero = model.jax_step(DT), jnp.zeros(model.coordinates)
    q, _ = jax.jit(step)(zero, zero, jnp.array([np.nan]))
    assert np.isnan(q).all()
    with pytest.raises(sf.InputError):
        step.check()
    assert np.isfinite(step(zero, zero, jnp.array([1e3]))[0]).all()
