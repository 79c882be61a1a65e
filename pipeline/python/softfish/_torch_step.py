"""One step of a reduced model as a function of PyTorch."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from softfish._optional import optional

if TYPE_CHECKING:
    from softfish._reduced import ReducedModel

torch: Any = optional("torch")


class _Step(torch.autograd.Function):  # type: ignore[misc]
    """Implicit Euler, and the adjoint of its equations."""

    @staticmethod
    def forward(ctx: Any, given: tuple[ReducedModel, float, Mapping[str, float]], *values: Any) -> Any:
        from softfish._reduced import ReducedState

        model, dt, settings = given
        q, v, pressures = (value.detach().to("cpu", torch.float64).numpy() for value in values)
        before = ReducedState(q, v)
        after = model.step(before, pressures, dt, **settings)
        ctx.kept = (given, before, after, pressures)
        ctx.like = values
        return tuple(torch.as_tensor(part, dtype=values[0].dtype) for part in (after.coordinates, after.velocity))

    @staticmethod
    @torch.autograd.function.once_differentiable  # type: ignore[untyped-decorator]
    def backward(ctx: Any, by_q: Any, by_v: Any) -> Any:
        from softfish._reduced import ReducedState

        (model, dt, settings), before, after, pressures = ctx.kept
        loss = ReducedState(by_q.to(torch.float64).numpy(), by_v.to(torch.float64).numpy())
        gradient = model.step_gradient((before, after), loss, pressures, dt, **settings)
        parts = (gradient.state.coordinates, gradient.state.velocity, gradient.pressures)
        return None, *(torch.as_tensor(part, dtype=like.dtype) for part, like in zip(parts, ctx.like, strict=True))


def torch_step(model: ReducedModel, dt: float, settings: Mapping[str, float]) -> Callable[[Any, Any, Any], Any]:
    """See `ReducedModel.torch_step`."""
    return lambda coordinates, velocity, pressures: _Step.apply((model, dt, settings), coordinates, velocity, pressures)
