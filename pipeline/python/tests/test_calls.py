"""Bad calls drawn over all public signatures, each in a process of its own: a typed error or a result, never a panic, an abort or a hang.

60 are drawn here; `SOFTFISH_CALLS=400` draws more."""

from __future__ import annotations

import inspect
import multiprocessing
import os
import signal
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import softfish as sf
from conftest import EXAMPLES, hollow

COUNT = int(os.environ.get("SOFTFISH_CALLS", "60"))
#: A call that takes longer hangs, s.
LIMIT = 20.0
BAD = [
    None, True, -1, 0, 1.9, 5, 10**30, 2**63, 1e300, -1e300, 1e-300, float("nan"), float("inf"), 1j, "soft", "", "\0", b"x", [], [[]], {}, {"nowhere": 1.0},
    {1: 2}, object(), object, np.zeros(0), np.zeros((2, 2)), np.full((1, 3), np.nan), np.array(["a"]), np.array([1, 2], dtype=object), np.float16(1),
    np.array([2**63], dtype=np.uint64), [1, [2, 3]], (1, 2, 3), range(3), lambda *_: 1 / 0, np.ma.masked, np.datetime64("2020-01-01"), {"air": None},
]


def subjects() -> dict[str, Any]:
    """What methods are called on, and what they are given where nothing bad is."""
    rubber = {"material": "neo_hookean", "youngs_modulus": 2e5, "poissons_ratio": 0.4, "density": 1000.0}
    case = sf.Case(
        {
            "region": [rubber],
            "clamp": [{"plane": {"x": 0.0}}],
            "chamber": [{"name": "air", "number": 0, "pressure": 5e3}],
            "static": {"levels": [0.5, 1.0]},
            "output": {"marker": [{"name": "tip", "at": [0.05, 0.015, 0.03]}]},
        },
        mesh=hollow(),
    )
    body = case.solver()
    found = body.equilibrium()
    model = body.reduce(np.stack([found.displacement, body.equilibrium(pressure=1e3).displacement]), 2)
    motion = body.simulate(2, 1e-3)
    state = model.rest()
    return {
        "Case": case, "Mesh": case.mesh, "Solver": body, "Equilibrium": found, "Motion": motion, "ReducedModel": model, "ReducedState": state,
        "Material": sf.Material(2e5, 0.4), "Inputs": body.inputs(),
    }


def defaults(of: dict[str, Any]) -> dict[str, Any]:
    """Good values by the name of an argument."""
    body, mesh, found = of["Solver"], of["Mesh"], of["Equilibrium"]
    return {
        "nodes": mesh.nodes, "elements": mesh.elements, "case": of["Case"], "mesh": mesh, "materials": of["Material"], "clamped": mesh.nodes[:, 0] == 0,
        "size": (1.0, 1.0, 1.0), "cells": (2, 2, 2), "path": EXAMPLES / "finger.msh", "unit": "mm", "source": EXAMPLES / "finger.toml", "text": "gravity = 3",
        "dloss_du": np.ones_like(found.displacement), "at": found, "faces": mesh.skin[:3], "traction": [0.0, 0.0, 1.0], "output": "marker.tip",
        "wrt": ["E.region_0"], "snapshots": np.stack([found.displacement]), "state": of["ReducedState"], "name": "marker.tip", "chamber": 0,
        "displacement": found.displacement, "solver": body, "states": (of["ReducedState"], of["ReducedState"]), "loss": of["ReducedState"],
        "steps": 2, "step": 1e-3, "youngs_modulus": 1e5, "poissons_ratio": 0.3, "body": EXAMPLES / "nowhere.stl", "edge": 0.01, "film": "nowhere.mp4",
        "page": "nowhere.toml", "columns": 5, "rows": 4, "square": 0.01, "folder": ".", "tolerance": 1e-6, "pressures": {"air": 1e3}, "timeout": 10.0,
    }


#: They hold what others made, or only say something.
RESULTS = {"Equilibrium", "Motion", "Path", "Gradient", "CriticalPoint", "Inputs", "ReducedState", "ReducedGradient", "Tracks", "Camera", "Fit", "FittedLaw", "Record"}


def signatures(of: dict[str, Any]) -> list[tuple[str, Callable[..., Any]]]:
    """Every public callable: functions, constructors, and methods of the subjects."""
    calls: list[tuple[str, Callable[..., Any]]] = []
    for name in sf.__all__:
        thing = getattr(sf, name)
        if isinstance(thing, type):
            if not issubclass(thing, Exception) and name not in RESULTS and name != "ReducedModel":
                calls.append((name, thing))
            if name in of:
                for method, _ in inspect.getmembers(type(of[name]), callable):
                    if not method.startswith("_"):
                        calls.append((f"{name}.{method}", getattr(of[name], method)))
        elif callable(thing):
            calls.append((name, thing))
    return calls


def arguments(call: Callable[..., Any], good: dict[str, Any], generator: np.random.Generator) -> dict[str, Any]:
    """Good values for what is required, bad ones for one or two arguments."""
    parameters = [one for one in inspect.signature(call).parameters.values() if one.kind in (one.POSITIONAL_OR_KEYWORD, one.KEYWORD_ONLY)]
    given = {one.name: good.get(one.name) for one in parameters if one.default is one.empty}
    for one in generator.choice(len(parameters), size=min(len(parameters), int(generator.integers(1, 3))), replace=False) if parameters else []:
        given[parameters[one].name] = BAD[generator.integers(len(BAD))]
    return given


def outcome(call: Callable[..., Any], given: dict[str, Any], queue: Any) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.stderr = sys.stdout = open(os.devnull, "w")  # noqa: SIM115
    try:
        call(**given)
        queue.put(("returned", ""))
    except sf.InternalError as error:
        queue.put(("panic", str(error)))
    except sf.Error as error:
        queue.put(("typed" if error.what and error.why and error.action else "untyped", str(error)))
    except ZeroDivisionError:
        # a callback's own
        queue.put(("typed", ""))
    except BaseException as error:
        queue.put(("untyped", f"{type(error).__name__}: {error}"))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="each call is made in a fork")
def test_bad_calls_have_a_typed_error_or_a_result(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    of = subjects()
    calls, good = signatures(of), defaults(of)
    context, generator = multiprocessing.get_context("fork"), np.random.default_rng(COUNT)
    wrong, counts = [], {"typed": 0, "returned": 0}
    for n in range(COUNT):
        name, call = calls[n % len(calls)]
        given = arguments(call, good, generator)
        queue = context.SimpleQueue()
        child = context.Process(target=outcome, args=(call, given, queue))
        child.start()
        child.join(LIMIT)
        hung = child.is_alive()
        if hung:
            child.kill()
            child.join()
        kind, said = ("hang", "") if hung else ("abort", f"exit code {child.exitcode}") if queue.empty() else queue.get()
        counts[kind] = counts.get(kind, 0) + 1
        if kind not in counts or kind in ("hang", "abort", "panic", "untyped"):
            bad = {key: repr(value)[:60] for key, value in given.items() if value is not good.get(key)}
            wrong.append(f"{name}({bad}): {kind} {said[:200]}")
    assert not wrong, "\n".join(wrong)
    assert counts["typed"] > COUNT / 3


