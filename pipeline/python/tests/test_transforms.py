"""Every transform of PyTorch and JAX over every function that differentiates: right against differences, or a typed refusal with its remedy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import softfish as sf

AT = 3e3
#: What comes back of a call: numbers, or a refusal.
Call = Callable[[], Any]


@pytest.fixture
def model(block: sf.Solver) -> sf.ReducedModel:
    loads = [{"pressure": p, "gravity": [0.0, 0.0, g]} for p in (1e3, 4e3) for g in (20.0, -20.0)]
    return block.reduce(np.stack([block.equilibrium(**load).displacement for load in loads]), 3)


def difference(function: Callable[[float], float]) -> float:
    """The derivative of a number by its argument."""
    return (function(AT * (1.0 + 1e-3)) - function(AT * (1.0 - 1e-3))) / (2e-3 * AT)


def check(calls: dict[str, tuple[Call, float | None]], refused: set[str]) -> None:
    """Each call gives its number or is refused; a second derivative has no number, so that nothing can pass for it."""
    for name, (call, truth) in calls.items():
        try:
            given = call()
            given = float(given.detach() if hasattr(given, "detach") else given)
        except sf.DerivativeError as error:
            assert name in refused and error.what and error.why and error.action, (name, str(error))
            continue
        assert name not in refused and truth is not None and given == pytest.approx(truth, rel=1e-3), (name, given, truth)


SECOND = {"create_graph", "penalty", "forward over reverse", "hessian", "hvp", "grad of grad", "jacfwd of jacfwd", "jacrev of jacfwd", "jit hessian"}
RECORDED = {"func grad", "func jacfwd", "func jvp", "func vjp", "func vmap", "func linearize", "vectorize", "vectorize forward", "batched", "trace"}


def torch_calls(function: Any, first: float) -> dict[str, tuple[Call, float | None]]:
    torch = pytest.importorskip("torch")
    autograd, functional, forward = torch.autograd, torch.autograd.functional, torch.autograd.forward_ad
    p = torch.tensor(AT, dtype=torch.float64)
    one = torch.ones_like(p)

    def leaf() -> Any:
        return p.clone().requires_grad_()

    def penalty(scale: float) -> Any:
        x = leaf()
        value = function(x)
        (slope,) = autograd.grad(value, x, create_graph=True)
        (scale * value + slope.square()).backward()
        return x.grad

    def dual(call: Callable[[Any], Any]) -> Any:
        with forward.dual_level():
            return forward.unpack_dual(call(forward.make_dual(leaf(), one))).tangent

    return {
        "grad": (lambda: autograd.grad(function(x := leaf()), x)[0], first),
        "forward": (lambda: dual(function), first),
        "jacobian": (lambda: functional.jacobian(function, p), first),
        "vjp": (lambda: functional.vjp(function, p)[1], first),
        "compile": (lambda: autograd.grad(torch.compile(function, backend="eager")(x := leaf()), x)[0], first),
        "create_graph": (lambda: penalty(0.0), None),
        "penalty": (lambda: penalty(1.0), None),
        "forward over reverse": (lambda: dual(lambda x: autograd.grad(function(x), x, create_graph=True)[0]), None),
        "hessian": (lambda: functional.hessian(function, p), None),
        "hvp": (lambda: functional.hvp(function, p, one)[1], None),
        "vectorize": (lambda: functional.jacobian(function, p, vectorize=True), first),
        "vectorize forward": (lambda: functional.jacobian(function, p, vectorize=True, strategy="forward-mode"), first),
        "batched": (lambda: autograd.grad(function(x := leaf()), x, one[None], is_grads_batched=True)[0], first),
        "func grad": (lambda: torch.func.grad(function)(p), first),
        "func jacfwd": (lambda: torch.func.jacfwd(function)(p), first),
        "func jvp": (lambda: torch.func.jvp(function, (p,), (one,))[1], first),
        "func vjp": (lambda: torch.func.vjp(function, p)[1](one)[0], first),
        "func vmap": (lambda: torch.func.vmap(function)(p[None])[0], None),
        "func linearize": (lambda: torch.func.linearize(function, p)[1](one), first),
        "trace": (lambda: autograd.grad(torch.jit.trace(function, leaf(), check_trace=False)(x := leaf()), x)[0], first),
    }


def jax_calls(function: Any, first: float) -> dict[str, tuple[Call, float | None]]:
    jax = pytest.importorskip("jax")
    jnp = jax.numpy
    p, one = jnp.array(AT), jnp.array(1.0)

    def along(x: Any) -> Any:
        return jax.jvp(function, (x,), (one,))[1]

    def scanned(x: Any) -> Any:
        return jax.lax.scan(lambda total, part: (total + function(part * x), 0.0), 0.0, jnp.ones(2))[0]

    return {
        "grad": (lambda: jax.grad(function)(p), first),
        "jit grad": (lambda: jax.jit(jax.grad(function))(p), first),
        "jacrev": (lambda: jax.jacrev(function)(p), first),
        "jacfwd": (lambda: jax.jacfwd(function)(p), first),
        "jvp": (lambda: along(p), first),
        "jit jvp": (lambda: jax.jit(along)(p), first),
        "vjp": (lambda: jax.vjp(function, p)[1](one)[0], first),
        "linearize": (lambda: jax.linearize(function, p)[1](one), first),
        "vmap grad": (lambda: jax.vmap(jax.grad(function))(jnp.array([AT, AT]))[1], first),
        "vmap jvp": (lambda: jax.vmap(along)(jnp.array([AT, AT]))[1], first),
        "grad vmap": (lambda: jax.grad(lambda x: jax.vmap(function)(jnp.ones(2) * x).sum())(p), 2.0 * first),
        "grad scan": (lambda: jax.jit(jax.grad(scanned))(p), 2.0 * first),
        "checkpoint": (lambda: jax.grad(jax.checkpoint(function))(p), first),
        "penalty": (lambda: jax.grad(lambda x: jax.grad(function)(x) ** 2)(p), None),
        "hessian": (lambda: jax.hessian(function)(p), None),
        "jit hessian": (lambda: jax.jit(jax.hessian(function))(p), None),
        "grad of grad": (lambda: jax.grad(jax.grad(function))(p), None),
        "jacfwd of jacfwd": (lambda: jax.jacfwd(jax.jacfwd(function))(p), None),
        "jacrev of jacfwd": (lambda: jax.jacrev(jax.jacfwd(function))(p), None),
    }


@pytest.mark.parametrize("kind", ["equilibrium", "motion", "step"])
def test_torch_is_right_or_refuses(block: sf.Solver, model: sf.ReducedModel, kind: str) -> None:
    torch = pytest.importorskip("torch")
    zero = torch.zeros(model.coordinates, dtype=torch.float64)
    step, rest = model.torch_step(2e-3), block.torch("marker.tip", ["pressure.air"])
    # of a motion by its modulus: its pressures have no forward mode
    motion = block.torch("marker.tip", ["E.region_0"], steps=3)
    functions = {
        "equilibrium": lambda p: 1e3 * rest(p).sum(),
        "motion": lambda p: 1e3 * motion(2e5 / AT * p).sum(),
        "step": lambda p: 1e3 * sum(part.sum() for part in step(zero, zero, p.reshape(1))),
    }
    function = functions[kind]
    first = difference(lambda at: float(function(torch.tensor(at, dtype=torch.float64))))
    check(torch_calls(function, first), SECOND | RECORDED)


@pytest.mark.parametrize("kind", ["equilibrium", "motion", "step"])
def test_jax_is_right_or_refuses(block: sf.Solver, model: sf.ReducedModel, kind: str) -> None:
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    zero = jax.numpy.zeros(model.coordinates)
    step, rest = model.jax_step(2e-3), block.jax("marker.tip", ["pressure.air"])
    motion = block.jax("marker.tip", ["E.region_0"], steps=3)
    functions = {
        "equilibrium": lambda p: 1e3 * rest(p).sum(),
        "motion": lambda p: 1e3 * motion(2e5 / AT * p).sum(),
        "step": lambda p: 1e3 * sum(part.sum() for part in step(zero, zero, p.reshape(1))),
    }
    function = functions[kind]
    first = difference(lambda at: float(function(at)) if kind != "step" else float(function(jax.numpy.array(at))))
    check(jax_calls(function, first), SECOND | RECORDED)


def test_a_direction_without_sensitivities_is_refused_in_forward_mode(block: sf.Solver) -> None:
    jax = pytest.importorskip("jax")
    motion, history = block.jax("marker.tip", ["pressure.air"], steps=3), np.full(3, AT)
    with pytest.raises(sf.DerivativeError, match="pressure.air") as caught:
        jax.jvp(motion, (history,), (history,))
    assert "reverse" in caught.value.action
    along = jax.jit(lambda p: jax.jvp(motion, (p,), (p,))[1])(history)
    assert np.isnan(along).all()
    with pytest.raises(sf.DerivativeError, match="pressure.air"):
        motion.check()
