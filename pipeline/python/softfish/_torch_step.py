"""One step of a reduced model as a function of PyTorch."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from softfish._errors import DerivativeError, InputError
from softfish._optional import optional
from softfish._torch import numbers, refuse_half, refuse_transforms

if TYPE_CHECKING:
    from softfish._reduced import ReducedModel

torch: Any = optional("torch")


class _Step(torch.autograd.Function):  # type: ignore[misc]
    """Implicit Euler, and the adjoint of its equations."""

    @staticmethod
    def forward(ctx: Any, given: tuple[TorchStep, Any], *values: Any) -> Any:
        from softfish._reduced import ReducedState

        step, dtype = given
        q, v, pressures = (numbers(value) for value in values)
        before = ReducedState(q, v)
        after = step.model.step(before, pressures, step.dt, **step.settings)
        ctx.kept = (step, before, after, pressures)
        ctx.save_for_backward(*values)
        device = values[0].device
        return tuple(torch.as_tensor(part, dtype=dtype, device=device) for part in (after.coordinates, after.velocity))

    @staticmethod
    def backward(ctx: Any, by_q: Any, by_v: Any) -> Any:
        refuse_transforms("the derivative of a step")
        return None, *_StepAdjoint.apply(ctx.kept, by_q, by_v, *ctx.saved_tensors)

    @staticmethod
    def jvp(_ctx: Any, *_tangents: Any) -> Any:
        why = "a step has derivatives in reverse mode alone"
        raise DerivativeError("a step of a reduced model has no forward mode", why, "use backward or torch.autograd.grad")


class _StepAdjoint(torch.autograd.Function):  # type: ignore[misc]
    """The adjoint of a step. It is no function that can be differentiated, and says so."""

    @staticmethod
    def forward(_ctx: Any, kept: Any, by_q: Any, by_v: Any, *values: Any) -> Any:
        from softfish._reduced import ReducedState

        step, before, after, pressures = kept
        loss = ReducedState(numbers(by_q), numbers(by_v))
        gradient = step.model.step_gradient((before, after), loss, pressures, step.dt, **step.settings)
        parts = (gradient.state.coordinates, gradient.state.velocity, gradient.pressures)
        return tuple(torch.as_tensor(part, dtype=like.dtype, device=like.device) for part, like in zip(parts, values, strict=True))

    @staticmethod
    def backward(_ctx: Any, *_cotangents: Any) -> Any:
        why = "a step has first derivatives alone"
        act = "leave create_graph out, or take the penalty by differences of the step"
        raise DerivativeError("a second derivative of a step is asked for", why, act)


class TorchStep:
    """See `ReducedModel.torch_step`."""

    def __init__(self, model: ReducedModel, dt: float, settings: Mapping[str, Any]) -> None:
        self.model = model
        self.dt = dt
        self.settings = dict(settings)

    @torch.compiler.disable  # type: ignore[untyped-decorator]
    def __call__(self, coordinates: Any, velocity: Any, pressures: Any) -> tuple[Any, Any]:
        """Coordinates and velocity after the step."""
        refuse_transforms("a step of a reduced model")
        values = (coordinates, velocity, pressures)
        count, chambers = self.model.coordinates, self.model._solver.chamber_count
        tensors = [value if isinstance(value, torch.Tensor) else torch.as_tensor(value, dtype=torch.float64) for value in values]
        for name, tensor, size in zip(("coordinates", "velocity", "pressures"), tensors, (count, count, chambers), strict=True):
            refuse_half(name, tensor)
            if tuple(tensor.shape) != (size,):
                raise InputError(f"`{name}` has the shape {tuple(tensor.shape)}", f"({size},) is required", "a step has no batch")
        single = all(tensor.dtype == torch.float32 for tensor in tensors)
        after: tuple[Any, Any] = _Step.apply((self, torch.float32 if single else torch.float64), *tensors)
        return after
