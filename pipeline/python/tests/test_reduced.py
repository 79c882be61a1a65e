"""Reduced models: against the full model, through a file, and their gradient against differences."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import softfish as sf


@pytest.fixture
def model(block: sf.Solver) -> sf.ReducedModel:
    shapes = [
        block.equilibrium(pressure={"air": p}, gravity=g).displacement
        for p in (1e3, 4e3, 8e3)
        for g in ([0.0, 0.0, 20.0], [0.0, 0.0, -20.0], [0.0, 20.0, 0.0], [0.0, -20.0, 0.0])
    ]
    return block.reduce(shapes, 12)


def test_steps_of_the_reduced_model_follow_those_of_the_full_one(block: sf.Solver, model: sf.ReducedModel) -> None:
    full = block.simulate(20, 2e-3, gravity=[0, 0, 0], pressure={"air": 5e3}, scheme="implicit_euler", stiffness_damping=1e-3)
    state = model.rest()
    for displacement in full.output("marker.tip"):
        state = model.step(state, {"air": 5e3}, 2e-3, stiffness_damping=1e-3)
    assert np.abs(model.output("marker.tip", state) - displacement).max() < 0.05 * np.abs(displacement).max()
    assert np.allclose(model.output_rows("marker.tip") @ state.coordinates, model.output("marker.tip", state))


def test_a_saved_model_is_the_same_and_that_of_another_body_is_refused(
    block: sf.Solver, brick: sf.Solver, model: sf.ReducedModel, tmp_path: Path
) -> None:
    path = tmp_path / "model.safetensors"
    model.save(path)
    again = sf.ReducedModel.load(path, block)
    state = model.step(model.rest(), {"air": 5e3}, 2e-3)
    other = again.step(again.rest(), {"air": 5e3}, 2e-3)
    assert np.array_equal(state.coordinates, other.coordinates)
    with pytest.raises(sf.InputError, match="no reduced model of this body"):
        sf.ReducedModel.load(path, brick)
    path.write_bytes(path.read_bytes()[:100])
    with pytest.raises(sf.InputError, match="cannot be read"):
        sf.ReducedModel.load(path, block)


def test_safetensors_reads_a_saved_model(model: sf.ReducedModel, tmp_path: Path) -> None:
    safetensors = pytest.importorskip("safetensors.numpy")
    model.save(tmp_path / "model.safetensors")
    tensors = safetensors.load_file(tmp_path / "model.safetensors")
    assert tensors["modes"].shape[0] == model.coordinates


def test_the_gradient_of_a_step_is_that_of_differences(model: sf.ReducedModel) -> None:
    start = model.step(model.rest(), {"air": 3e3}, 2e-3)
    loss = sf.ReducedState(np.ones(model.coordinates), np.full(model.coordinates, 1e-3))

    def value(pressure: float) -> float:
        after = model.step(start, {"air": pressure}, 2e-3)
        return float(loss.coordinates @ after.coordinates + loss.velocity @ after.velocity)

    after = model.step(start, {"air": 5e3}, 2e-3)
    gradient = model.step_gradient((start, after), loss, {"air": 5e3}, 2e-3)
    assert gradient.pressures[0] == pytest.approx((value(5005.0) - value(4995.0)) / 10.0, rel=1e-5)


def test_a_rollout_passes_gradcheck(model: sf.ReducedModel) -> None:
    torch = pytest.importorskip("torch")
    step, rows = model.torch_step(2e-3), torch.tensor(model.output_rows("marker.tip"))

    def rollout(pressures):
        q = v = torch.zeros(model.coordinates, dtype=torch.float64)
        for pressure in pressures:
            q, v = step(q, v, 5e3 * pressure.reshape(1))
        return 1e3 * rows @ q

    history = torch.linspace(0.2, 1.0, 5, dtype=torch.float64, requires_grad=True)
    torch.autograd.gradcheck(rollout, (history,), eps=1e-4, atol=1e-5, rtol=1e-4)


def test_a_batch_of_steps_is_the_cases_one_after_the_other(model: sf.ReducedModel) -> None:
    torch = pytest.importorskip("torch")
    step = model.torch_step(2e-3, stiffness_damping=1e-3)
    q, v = torch.tensor(1e-3 * np.ones(model.coordinates), requires_grad=True), torch.zeros(model.coordinates, dtype=torch.float64)
    pressures = torch.tensor([[1e3], [3e3], [5e3]], dtype=torch.float64, requires_grad=True)
    together = step(q, v, pressures)
    singles = [step(q, v, pressure) for pressure in pressures]
    for n in (0, 1):
        assert torch.equal(together[n], torch.stack([single[n] for single in singles]))
    batched = torch.autograd.grad(together[0].square().sum() + together[1].sum(), (q, pressures))
    summed = torch.autograd.grad(sum(a.square().sum() + b.sum() for a, b in singles), (q, pressures))
    assert all(torch.allclose(a, b, rtol=1e-12) for a, b in zip(batched, summed, strict=True))
    for wrong in ((q[None, :2], v, pressures), (q.expand(2, -1), v, pressures), (q, v, pressures[None]), (q, v, pressures[:0])):
        with pytest.raises(sf.InputError):
            step(*wrong)


def test_an_equilibrium_is_that_of_the_whole_body_and_its_gradient_that_of_differences(block: sf.Solver, model: sf.ReducedModel) -> None:
    state = model.equilibrium({"air": 6e3})
    whole = block.equilibrium(pressure={"air": 6e3}, gravity=[0, 0, 0]).displacement
    assert np.abs(model.displacement(state) - whole).max() < 0.03 * np.abs(whole).max()
    region = block.regions[0]
    E, nu = block._base.youngs_modulus[0], block._base.poissons_ratio[0]
    loss = np.linspace(-1.0, 1.0, model.coordinates)

    def value(pressure: float = 6e3, modulus: float = E, ratio: float = nu) -> float:
        return float(loss @ model.equilibrium({"air": pressure}, E={region: modulus}, nu={region: ratio}).coordinates)

    gradient = model.equilibrium_gradient(state, loss, {"air": 6e3})
    for found, high, low, step in [
        (gradient.pressures[0], value(6010.0), value(5990.0), 20.0),
        (gradient.E[0], value(modulus=1.001 * E), value(modulus=0.999 * E), 2e-3 * E),
        (gradient.nu[0], value(ratio=nu + 1e-4), value(ratio=nu - 1e-4), 2e-4),
    ]:
        assert found == pytest.approx((high - low) / step, rel=1e-4)


def test_what_lies_outside_the_trained_ranges_is_refused(block: sf.Solver, model: sf.ReducedModel) -> None:
    region = block.regions[0]
    trained = sf.ReducedModel(block, model._core, {"air": (0.0, 8e3), f"E.{region}": (1e4, 1e9)})
    assert trained.trained["air"] == (0.0, 8e3)
    trained.equilibrium({"air": 7e3})
    with pytest.raises(sf.InputError, match="`air` is 9000"):
        trained.equilibrium({"air": 9e3})
    with pytest.raises(sf.InputError, match=rf"`E.{region}` is 10"):
        trained.equilibrium({"air": 1e3}, E={region: 10.0})


def test_a_model_is_trained_over_ranges_and_refuses_what_lies_outside(finger: sf.Solver) -> None:
    region, chamber = finger.regions[0], finger.chambers[0]
    ranges = {f"E.{region}": (1.5e5, 2.5e5)}
    model = finger.reduce(over=ranges, pressure={chamber: (0.0, 6e3)}, tolerance=1e-2)
    state = model.equilibrium({chamber: 5e3}, E={region: 1.8e5})
    whole = finger.equilibrium(pressure={chamber: 5e3}, E={region: 1.8e5}).displacement
    assert np.abs(model.displacement(state) - whole).max() < 1e-2 * np.abs(whole).max()
    assert model.trained[chamber] == (0.0, 6e3) and model.trained[f"E.{region}"] == (1.5e5, 2.5e5)
    with pytest.raises(sf.InputError):
        model.equilibrium({chamber: 9e3})


def test_trainings_that_cannot_be_are_refused(finger: sf.Solver, block: sf.Solver) -> None:
    chamber = finger.chambers[0]
    for arguments, words in [
        ({}, "either"),
        ({"pressure": {"none": (0.0, 1.0)}}, "there is no chamber"),
        ({"pressure": {chamber: (0.0, 0.0)}}, "no pressure varies"),
        ({"pressure": {chamber: (2.0, 1.0)}}, "low, high"),
        ({"pressure": {chamber: (0.0, 1e3)}, "over": {"mu.x": (1.0, 2.0)}}, "known are E."),
        ({"pressure": {chamber: (0.0, 1e3)}, "coordinates": 4}, "coordinates"),
    ]:
        with pytest.raises(sf.Error, match=words):
            finger.reduce(**arguments)  # type: ignore[arg-type]
    with pytest.raises(sf.InputError, match="gravity"):
        block.reduce(pressure={"air": (0.0, 1e3)})
