"""One step of a reduced model as a function of PyTorch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from softfish._errors import DerivativeError, InputError
from softfish._optional import optional
from softfish._torch import numbers, outside_graphs, refuse_half, refuse_transforms

if TYPE_CHECKING:
    from softfish._reduced import ReducedModel

torch: Any = optional("torch")


class _Step(torch.autograd.Function):  # type: ignore[misc]
    """Implicit Euler of each case of a batch, and the adjoint of its equations."""

    @staticmethod
    def forward(ctx: Any, given: tuple[TorchStep, Any], *values: Any) -> Any:
        from softfish._reduced import ReducedState

        step, dtype = given
        coordinates, velocities, pressures = (numbers(value) for value in values)
        before = [ReducedState(q, v) for q, v in zip(coordinates, velocities, strict=True)]
        pairs = list(zip(before, pressures, strict=True))
        after = [step.model.step(state, pressure, step.dt, **step.settings) for state, pressure in pairs]
        ctx.kept = (step, before, after, pressures)
        ctx.save_for_backward(*values)
        parts = ([state.coordinates for state in after], [state.velocity for state in after])
        return tuple(torch.as_tensor(np.stack(part), dtype=dtype, device=values[0].device) for part in parts)

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
        losses = [ReducedState(q, v) for q, v in zip(numbers(by_q), numbers(by_v), strict=True)]
        gradients = [
            step.model.step_gradient(states, loss, pressure, step.dt, **step.settings)
            for states, loss, pressure in zip(zip(before, after, strict=True), losses, pressures, strict=True)
        ]
        parts = (
            [gradient.state.coordinates for gradient in gradients],
            [gradient.state.velocity for gradient in gradients],
            [gradient.pressures for gradient in gradients],
        )
        pairs = zip(parts, values, strict=True)
        return tuple(torch.as_tensor(np.stack(part), dtype=like.dtype, device=like.device) for part, like in pairs)

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

    @outside_graphs
    def __call__(self, coordinates: Any, velocity: Any, pressures: Any) -> tuple[Any, Any]:
        """Coordinates and velocity after the step; a first axis of any argument is a batch."""
        refuse_transforms("a step of a reduced model")
        values = (coordinates, velocity, pressures)
        tensors = [value if isinstance(value, torch.Tensor) else torch.as_tensor(value, dtype=torch.float64) for value in values]
        batch = self._batch(tensors)
        single = all(tensor.dtype == torch.float32 for tensor in tensors)
        # what is the same in all cases is expanded, so that its gradient is their sum
        full = [tensor.expand(1 if batch is None else batch, tensor.shape[-1]) for tensor in tensors]
        q, v = _Step.apply((self, torch.float32 if single else torch.float64), *full)
        return (q[0], v[0]) if batch is None else (q, v)

    def _batch(self, tensors: Sequence[Any]) -> int | None:
        """The number of cases, of arguments of the right precision and shape."""
        count, chambers = self.model.coordinates, self.model._solver.chamber_count
        sizes = set()
        for name, tensor, size in zip(("coordinates", "velocity", "pressures"), tensors, (count, count, chambers), strict=True):
            refuse_half(name, tensor)
            if tuple(tensor.shape[-1:]) != (size,) or tensor.dim() > 2:
                raise InputError(f"`{name}` has the shape {tuple(tensor.shape)}", f"it is ({size},), or a batch of that", "check its axes")
            sizes |= set(tensor.shape[:-1])
        if len(sizes) > 1 or 0 in sizes:
            raise InputError(f"batches have the sizes {sorted(sizes)}", "a call has one batch", "give equal sizes above 0")
        return sizes.pop() if sizes else None
