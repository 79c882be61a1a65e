"""Derivatives of PyTorch against differences: at rest and in ten steps of motion."""

from __future__ import annotations

import numpy as np
import pytest

import softfish as sf

torch = pytest.importorskip("torch")
SCALE = 1e3
WRT = ["E.region_0", "nu.region_0", "pressure.air"]


def values(*numbers: float, grad: bool = True) -> list:
    return [torch.tensor(number, dtype=torch.float64, requires_grad=grad) for number in numbers]


def scaled(call, factors):
    """The same function of arguments and outputs of order one, where differences are exact enough for 1e-6."""
    return lambda *args: SCALE * call(*(factor * arg for factor, arg in zip(factors, args, strict=True)))


@pytest.mark.parametrize("wrt, factor, at", [("E.region_0", 2e5, 1.0), ("nu.region_0", 1.0, 0.4), ("pressure.air", 5e3, 1.0)])
def test_a_gradient_at_rest_passes_gradcheck(block: sf.Solver, wrt: str, factor: float, at: float) -> None:
    call = scaled(block.torch("marker.tip", [wrt]), [factor])
    torch.autograd.gradcheck(call, values(at), eps=1e-5, atol=1e-6, rtol=1e-6, check_forward_ad=True)


def test_gradients_by_elements_and_forces_at_rest_pass_gradcheck(brick: sf.Solver) -> None:
    elements, nodes = len(brick.element_regions), len(brick.mesh.nodes)
    generator = np.random.default_rng(1)
    moduli = torch.tensor(generator.uniform(0.8, 1.2, elements), requires_grad=True)
    forces = torch.tensor(generator.normal(size=(nodes, 3)), requires_grad=True)
    function = brick.torch("displacement", ["element_E", "force"])
    pick = torch.tensor(generator.normal(size=(nodes, 3)))
    call = scaled(lambda *args: (pick * function(*args)).sum(), [2e5, 1e-4])
    torch.autograd.gradcheck(call, (moduli, forces), eps=1e-5, atol=1e-6, rtol=1e-6)


@pytest.mark.parametrize("wrt, factor, at", [("E.region_0", 2e5, 1.0), ("nu.region_0", 1.0, 0.4)])
def test_a_gradient_of_ten_steps_passes_gradcheck(block: sf.Solver, wrt: str, factor: float, at: float) -> None:
    call = scaled(block.torch("marker.tip", [wrt], steps=10), [factor])
    torch.autograd.gradcheck(call, values(at), eps=1e-5, atol=1e-6, rtol=1e-6, check_forward_ad=True)


def test_a_gradient_of_ten_steps_by_a_pressure_history_passes_gradcheck(block: sf.Solver) -> None:
    call = scaled(block.torch("marker.tip", ["pressure.air"], steps=10), [5e3])
    history = torch.linspace(0.2, 1.0, 10, dtype=torch.float64, requires_grad=True)
    torch.autograd.gradcheck(call, (history,), eps=1e-5, atol=1e-6, rtol=1e-6)


def test_gradients_of_ten_steps_by_elements_and_forces_pass_gradcheck(brick: sf.Solver) -> None:
    elements, nodes = len(brick.element_regions), len(brick.mesh.nodes)
    generator = np.random.default_rng(2)
    moduli = torch.tensor(generator.uniform(0.8, 1.2, elements), requires_grad=True)
    forces = torch.tensor(generator.normal(size=(nodes, 3)), requires_grad=True)
    function = brick.torch("displacement", ["element_E", "force"], steps=10, step=2e-3)
    pick = torch.tensor(generator.normal(size=(10, nodes, 3)))
    call = scaled(lambda *args: (pick * function(*args)).sum(), [2e5, 1e-4])
    torch.autograd.gradcheck(call, (moduli, forces), eps=1e-5, atol=1e-5, rtol=1e-6, fast_mode=True)


def test_a_batch_is_the_cases_one_after_the_other(block: sf.Solver) -> None:
    call = block.torch("marker.tip", WRT)
    moduli = torch.tensor([1.5e5, 2e5, 3e5], dtype=torch.float64, requires_grad=True)
    ratio, pressure = values(0.4, 4e3)
    together = call(moduli, ratio, pressure)
    assert together.shape == (3, 3)
    together.square().sum().backward()
    singles = [value.detach().clone().requires_grad_() for value in moduli]
    other, also = values(0.4, 4e3)
    sum(call(single, other, also).square().sum() for single in singles).backward()
    assert torch.allclose(moduli.grad, torch.stack([single.grad for single in singles]), rtol=1e-8)
    assert torch.allclose(ratio.grad, other.grad, rtol=1e-8) and torch.allclose(pressure.grad, also.grad, rtol=1e-8)


def test_single_precision_gives_single_precision(block: sf.Solver) -> None:
    call = block.torch("marker.tip", ["E.region_0"])
    modulus = torch.tensor(2e5, dtype=torch.float32, requires_grad=True)
    tip = call(modulus)
    tip.sum().backward()
    double = torch.tensor(2e5, dtype=torch.float64, requires_grad=True)
    call(double).sum().backward()
    assert tip.dtype == torch.float32 and modulus.grad.dtype == torch.float32
    assert modulus.grad.item() == pytest.approx(double.grad.item(), rel=1e-6)


def test_a_second_backward_is_right_and_a_second_derivative_is_refused(block: sf.Solver) -> None:
    (modulus,) = values(2e5)
    loss = block.torch("marker.tip", ["E.region_0"])(modulus).sum()
    (first,) = torch.autograd.grad(loss, modulus, retain_graph=True)
    (second,) = torch.autograd.grad(loss, modulus, create_graph=True)
    assert first.item() == pytest.approx(second.item(), rel=1e-9)
    with pytest.raises(sf.InputError, match="second derivative"):
        second.backward()


def test_a_failed_solve_raises_its_own_exception_and_the_next_one_works(block: sf.Solver) -> None:
    call = block.torch("marker.tip", ["pressure.air"])
    with pytest.raises(sf.ConvergenceError):
        call(torch.tensor(9e6, dtype=torch.float64))
    assert torch.isfinite(call(torch.tensor(1e3, dtype=torch.float64))).all()


def test_a_modulus_is_found_again_by_gradient_descent(block: sf.Solver) -> None:
    call = block.torch("marker.tip", ["E.region_0"])
    measured = call(torch.tensor(2.3e5, dtype=torch.float64))
    log = torch.tensor(np.log(1.5e5), requires_grad=True)
    optimiser = torch.optim.LBFGS([log], max_iter=30, line_search_fn="strong_wolfe")

    def closure():
        optimiser.zero_grad()
        loss = ((call(log.exp()) - measured) * 1e4).square().sum()
        loss.backward()
        return loss

    optimiser.step(closure)
    assert log.exp().item() == pytest.approx(2.3e5, rel=1e-5)
