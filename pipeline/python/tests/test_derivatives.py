"""No gradient is wrong in silence: what a solve does not have is refused by a typed error with a remedy."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest

import softfish as sf

OVERLAPS = [
    ["E", "E.region_0"], ["E.region_0", "E.region_0"], ["pressure.air", "pressure"], ["nu.region_0", "nu"],
    ["element_E", "E.region_0"], ["E.elements", "element_E"], ["force", "force"], ["density", "density"],
]


@pytest.mark.parametrize("wrt", OVERLAPS)
@pytest.mark.parametrize("kind", ["torch", "jax"])
def test_parameters_that_set_the_same_number_are_refused(block: sf.Solver, wrt: list[str], kind: str) -> None:
    pytest.importorskip(kind)
    with pytest.raises(sf.InputError, match="both in `wrt`") as caught:
        getattr(block, kind)("marker.tip", wrt)
    assert caught.value.why and caught.value.action


@pytest.mark.parametrize("settings, word", [
    ({"E": 1e5}, "beside"), ({"element_E": np.ones(3)}, "beside"), ({"colour": 3}, "no setting"), ({"steps": 1.5}, "steps"),
    ({"tolerance": -1.0}, "tolerance"), ({"scheme": "bdf2"}, "no setting"), ({"level": 1.0, "steps": 3}, "no setting"),
    ({"initial_guess": np.zeros((2, 3))}, "initial_guess"), ({"reuse_factor": True}, "no effect"), ({"pressure": {"water": 1.0}}, "water"),
    ({"nu": 0.7}, "Poisson"), ({"gravity": [1.0]}, "gravity"), ({"steps": 3, "initial": 5}, "initial"), ({"steps": 3, "mass_damping": -1.0}, "mass_damping"),
    ({"steps": 3, "pressure": {"air": [1.0, 2.0]}}, "steps"), ({"steps": 3, "scheme": "quasi_static", "stiffness_damping": 1.0}, "no effect"),
])
@pytest.mark.parametrize("kind", ["torch", "jax"])
def test_settings_are_checked_when_the_function_is_made(block: sf.Solver, settings: dict, word: str, kind: str) -> None:
    pytest.importorskip(kind)
    with pytest.raises(sf.InputError, match=word):
        getattr(block, kind)("marker.tip", ["E.region_0"], **settings)


def differences(function: Any, at: float, part: float = 1e-4) -> np.ndarray:
    return (np.asarray(function(at * (1 + part))) - np.asarray(function(at * (1 - part)))) / (2 * part * at)


def _module(torch: Any, tip: Any) -> Any:
    """A module that calls a function with a constant."""

    class Tip(torch.nn.Module):
        def forward(self, p: Any) -> Any:
            return tip(2e5, p)

    return Tip()


class TestTorch:
    torch = None

    @pytest.fixture(autouse=True)
    def _torch(self) -> None:
        type(self).torch = pytest.importorskip("torch")

    def number(self, value: float, dtype: str = "float64") -> Any:
        return self.torch.tensor(value, dtype=getattr(self.torch, dtype), requires_grad=True)

    def test_second_derivatives_are_refused_wherever_they_are_asked_for(self, block: sf.Solver) -> None:
        torch, tip = self.torch, block.torch("marker.tip", ["pressure.air"])
        p = self.number(3e3)
        slope, = torch.autograd.grad(tip(p).sum(), p, create_graph=True)
        with pytest.raises(sf.DerivativeError, match="second derivative") as caught:
            slope.backward()
        assert caught.value.action
        with pytest.raises(sf.DerivativeError):
            torch.autograd.functional.hessian(lambda x: tip(x).sum(), p)

    @pytest.mark.parametrize("transform", ["vmap", "grad", "jacrev", "jacfwd", "hessian", "jvp", "vjp"])
    def test_transforms_of_torch_func_are_refused(self, block: sf.Solver, transform: str) -> None:
        torch, tip = self.torch, block.torch("marker.tip", ["pressure.air"])
        p = torch.tensor(3e3, dtype=torch.float64)
        calls = {
            "vmap": lambda: torch.func.vmap(tip)(torch.stack([p, p])),
            "jvp": lambda: torch.func.jvp(tip, (p,), (p,)),
            "vjp": lambda: torch.func.vjp(tip, p),
        }
        with pytest.raises(sf.DerivativeError, match="torch.func"):
            calls.get(transform, lambda: getattr(torch.func, transform)(lambda x: tip(x).sum())(p))()

    def test_jacobians_are_right_or_refused(self, block: sf.Solver) -> None:
        torch, tip = self.torch, block.torch("marker.tip", ["pressure.air"])
        p = torch.tensor(3e3, dtype=torch.float64)
        by_differences = differences(lambda x: tip(torch.tensor(x, dtype=torch.float64)).numpy(), 3e3)
        functional = torch.autograd.functional
        assert np.allclose(functional.jacobian(tip, p).numpy(), by_differences, rtol=1e-5)
        with pytest.raises(sf.DerivativeError, match="second derivative") as twice:
            functional.jvp(tip, p, torch.ones_like(p))
        assert "forward_ad" in twice.value.action
        with pytest.raises(sf.DerivativeError):
            functional.jacobian(tip, p, vectorize=True)
        with torch.autograd.forward_ad.dual_level():
            dual = torch.autograd.forward_ad.make_dual(p, torch.ones_like(p))
            tangent = torch.autograd.forward_ad.unpack_dual(tip(dual)).tangent
        assert np.allclose(tangent.numpy(), by_differences, rtol=1e-5)

    def test_precisions_are_promoted_and_half_is_refused(self, block: sf.Solver) -> None:
        torch, tip = self.torch, block.torch("marker.tip", ["E.region_0", "pressure.air"])
        exact = tip(self.number(2e5), self.number(3e3))
        E, p = self.number(2e5, "float32"), self.number(3e3)
        mixed = tip(E, p)
        assert mixed.dtype == torch.float64 and torch.equal(mixed, exact)
        mixed.sum().backward()
        assert E.grad.dtype == torch.float32 and p.grad.dtype == torch.float64
        assert tip(E, self.number(3e3, "float32")).dtype == torch.float32
        assert torch.equal(tip(self.number(2e5), 3000.125), tip(self.number(2e5), self.number(3000.125)))
        for dtype in ("float16", "bfloat16", "int64", "complex64", "bool"):
            with pytest.raises(sf.InputError, match="holds"):
                tip(self.number(2e5), torch.tensor(3).to(getattr(torch, dtype)))

    def test_a_compiled_function_has_the_same_gradient(self, block: sf.Solver) -> None:
        torch, tip = self.torch, block.torch("marker.tip", ["pressure.air"])
        p = self.number(3e3)
        plain, = torch.autograd.grad((tip(p) ** 2).sum(), p)
        compiled = torch.compile(lambda x: (tip(x) ** 2).sum(), backend="eager")
        got, = torch.autograd.grad(compiled(p), p)
        assert got.item() == pytest.approx(plain.item(), rel=1e-12)

    @pytest.mark.parametrize("backend", ["eager", "aot_eager"])
    def test_a_whole_graph_has_the_same_gradient(self, block: sf.Solver, backend: str) -> None:
        torch = self.torch
        if not hasattr(torch.library, "custom_op"):
            pytest.skip("operations of one's own are there from PyTorch 2.4 on")
        tip, motion = block.torch("marker.tip", ["E.region_0", "pressure.air"]), block.torch("marker.tip", ["E.region_0"], steps=3)
        shapes = np.stack([block.equilibrium(pressure=p, gravity=[0, 0, 0]).displacement for p in (1e3, 3e3, 5e3)])
        step = block.reduce(shapes, 3).torch_step(2e-3)
        zero = torch.zeros(step.model.coordinates, dtype=torch.float64)

        def steps(p: Any) -> Any:
            q, v = step(zero, zero, p.reshape(1))
            q, v = step(q, v, 2.0 * p.reshape(1))
            return 1e3 * q.sum() + v.sum()

        losses = {
            "equilibrium": lambda E, p: (1e4 * tip(E, p)).square().sum(),
            "batch": lambda E, p: (1e4 * tip(E, torch.stack([p, 2.0 * p]))).square().sum(),
            "constant": lambda E, p: (1e4 * tip(E, 3e3)).square().sum() + 0.0 * p,
            "motion": lambda E, p: 1e6 * motion(E).sum() + 0.0 * p,
            "steps": lambda E, p: steps(p) + 0.0 * E,
        }
        for name, loss in losses.items():
            at = (self.number(2e5), self.number(3e3))
            whole = torch.compile(loss, backend=backend, fullgraph=True)
            value = whole(*at)
            assert value.item() == pytest.approx(loss(*at).item(), rel=1e-12), name
            for mine, plain in zip(torch.autograd.grad(value, at), torch.autograd.grad(loss(*at), at), strict=True):
                assert mine.item() == pytest.approx(plain.item(), rel=1e-9), name
        exported = torch.export.export(_module(torch, tip), (torch.tensor(3e3, dtype=torch.float64),)).module()
        assert torch.allclose(exported(torch.tensor(4e3, dtype=torch.float64)), tip(2e5, 4e3), rtol=1e-12)

    def test_a_graph_has_no_other_derivatives(self, block: sf.Solver) -> None:
        torch = self.torch
        if not hasattr(torch.library, "custom_op"):
            pytest.skip("operations of one's own are there from PyTorch 2.4 on")
        tip, p = block.torch("marker.tip", ["E.region_0", "pressure.air"]), torch.tensor(3e3, dtype=torch.float64)
        exported, one = torch.export.export(_module(torch, tip), (p,)).module(), torch.ones_like(p)
        for call in (lambda: torch.func.jvp(exported, (p,), (one,)), lambda: torch.func.jacfwd(exported)(p)):
            with pytest.raises(sf.DerivativeError, match="forward mode"):
                call()
        for backend in ("eager", "aot_eager"):
            for transform in (torch.func.jacfwd, torch.func.jacrev, torch.func.vmap):
                torch._dynamo.reset()
                at = p[None] if transform is torch.func.vmap else p
                with pytest.raises((RuntimeError, sf.DerivativeError)):
                    torch.compile(transform(lambda x: tip(2e5, x)), backend=backend, fullgraph=True)(at)
        slope, = torch.autograd.grad(torch.compile(lambda x: tip(2e5, x).sum(), backend="eager", fullgraph=True)(q := self.number(3e3)), q, create_graph=True)
        with pytest.raises(sf.DerivativeError, match="second derivative"):
            slope.backward()
        for wrong in (torch.zeros(2, 2, dtype=torch.float64), p.half()):
            with pytest.raises((RuntimeError, sf.InputError)):
                torch.compile(lambda x: tip(2e5, x), backend="eager", fullgraph=True)(wrong)

    def test_a_step_of_a_reduced_model_refuses_a_penalty_of_its_gradient(self, block: sf.Solver) -> None:
        torch = self.torch
        shapes = np.stack([block.equilibrium(pressure=p, gravity=[0, 0, 0]).displacement for p in (1e3, 3e3, 5e3)])
        model = block.reduce(shapes, 3)
        step = model.torch_step(2e-3)
        zero = torch.zeros(model.coordinates, dtype=torch.float64)
        p = torch.tensor([3e3], dtype=torch.float64, requires_grad=True)
        q, _ = step(zero, zero, p)
        slope, = torch.autograd.grad(q.sum(), p, create_graph=True)
        with pytest.raises(sf.DerivativeError, match="second derivative"):
            (q.sum() + slope.square().sum()).backward()
        by_differences = differences(lambda x: float(step(zero, zero, torch.tensor([x], dtype=torch.float64))[0].sum()), 3e3)
        assert slope.item() == pytest.approx(float(by_differences), rel=1e-5)
        with pytest.raises(sf.DerivativeError):
            torch.func.vmap(lambda x: step(zero, zero, x)[0])(torch.stack([p, p]))
        with pytest.raises(sf.InputError, match="holds"):
            step(zero, zero, p.detach().half())
        for wrong in ({"dt": 0.0}, {"modulus_scale": [0.0]}, {"modulus_scale": [-1.0]}, {"mass_damping": "much"}):
            with pytest.raises(sf.InputError):
                model.torch_step(**wrong)

    def test_arguments_of_a_call_are_checked(self, block: sf.Solver) -> None:
        tip = block.torch("marker.tip", ["pressure.air"])
        for wrong in (lambda: tip(), lambda: tip("soft"), lambda: tip(None), lambda: tip(float("nan")), lambda: tip(pressure=3e3), lambda: tip(3e3, 3e3)):
            with pytest.raises(sf.InputError):
                wrong()

    def test_functions_are_copied_with_their_solver(self, block: sf.Solver) -> None:
        torch, tip = self.torch, block.torch("marker.tip", ["pressure.air"])
        p = self.number(3e3)
        for again in (copy.deepcopy(tip), pickle.loads(pickle.dumps(tip))):
            assert torch.allclose(again(p), tip(p), rtol=1e-9)


class TestJax:
    @pytest.fixture(autouse=True)
    def _jax(self) -> None:
        self.jax = pytest.importorskip("jax")
        self.jax.config.update("jax_enable_x64", True)

    def test_second_derivatives_are_refused(self, block: sf.Solver) -> None:
        jax, tip = self.jax, block.jax("marker.tip", ["pressure.air"])
        loss = lambda p: (tip(p) ** 2).sum()
        by_differences = differences(loss, 3e3)
        assert float(jax.grad(loss)(3e3)) == pytest.approx(float(by_differences), rel=1e-5)
        for call in (
            lambda: jax.hessian(loss)(3e3), lambda: jax.jacfwd(jax.jacfwd(tip))(3e3), lambda: jax.grad(jax.grad(loss))(3e3),
            lambda: jax.jit(jax.hessian(loss))(3e3), lambda: jax.jacrev(jax.jacrev(tip))(3e3),
        ):
            with pytest.raises(sf.DerivativeError) as caught:
                call()
            assert caught.value.why and caught.value.action

    def test_forward_mode_is_right(self, block: sf.Solver) -> None:
        jax, tip = self.jax, block.jax("marker.tip", ["pressure.air"])
        by_differences = differences(tip, 3e3)
        assert np.allclose(jax.jvp(tip, (3e3,), (1.0,))[1], by_differences, rtol=1e-5)
        assert np.allclose(jax.jacfwd(tip)(3e3), by_differences, rtol=1e-5)

    def test_batches_and_precisions(self, block: sf.Solver) -> None:
        jax = self.jax
        tip = block.jax("marker.tip", ["E.region_0", "pressure.air"])
        many = jax.vmap(lambda p: tip(2e5, p))(jax.numpy.array([1e3, 3e3]))
        assert np.allclose(many[1], tip(2e5, 3e3), rtol=1e-9)
        single = jax.numpy.float32(3e3)
        assert tip(jax.numpy.float64(2e5), single).dtype == np.float64
        with pytest.raises(sf.InputError, match="half"):
            tip(2e5, jax.numpy.float16(3e3))
        again = pickle.loads(pickle.dumps(tip))
        assert np.allclose(again(2e5, 3e3), tip(2e5, 3e3), rtol=1e-9)
        for wrong in ({"mode": "reverse"}, {"kept": 0}, {"kept": 2.5}):
            with pytest.raises(sf.InputError):
                block.jax("marker.tip", ["E"], **wrong)
