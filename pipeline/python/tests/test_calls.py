"""Bad calls drawn over all public signatures, each in a process of its own: a typed error or a result that the bad argument has an effect on, never
a panic, an abort, a hang or an error of another kind.

60 are drawn here; `SOFTFISH_CALLS=400` draws more, `SOFTFISH_SEED` others."""

from __future__ import annotations

import dataclasses
import inspect
import multiprocessing
import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import softfish as sf
from conftest import EXAMPLES, hollow
from softfish import mosaic

COUNT = int(os.environ.get("SOFTFISH_CALLS", "60"))
SEED = int(os.environ.get("SOFTFISH_SEED", "68"))
#: A call that takes longer hangs, s.
LIMIT = 20.0
BAD = [
    None, True, -1, 0, 1.9, 5, 10**30, 2**63, 1e300, -1e300, 1e-300, float("nan"), float("inf"), 1j, "soft", "", "\0", b"x", [], [[]], {}, {"nowhere": 1.0},
    {1: 2}, object(), object, np.zeros(0), np.zeros((2, 2)), np.full((1, 3), np.nan), np.array(["a"]), np.array([1, 2], dtype=object), np.float16(1),
    np.array([2**63], dtype=np.uint64), [1, [2, 3]], (1, 2, 3), range(3), lambda *_: 1 / 0, np.ma.masked, np.datetime64("2020-01-01"), {"air": None},
]


def subjects(folder: Path) -> dict[str, Any]:
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
    state = model.step(model.rest(), {"air": 1e3})
    (folder / "data/processed/mesh/all/record").mkdir(parents=True)
    (folder / "study.toml").write_text("")
    (folder / "data/processed/mesh/all/record/mesh.json").write_text("{}")
    project = sf.Project(folder)
    law = sf.FittedLaw("elastic", ["E"], ["Pa"], np.ones(1), np.eye(1), 0.0, True)
    return {
        "Case": case, "Mesh": case.mesh, "Solver": body, "Equilibrium": found, "Motion": body.simulate(2, 1e-3), "ReducedModel": model, "ReducedState": state,
        "Material": sf.Material(2e5, 0.4), "Inputs": body.inputs(), "Project": project, "Record": project.record("mesh", stale=True),
        "Fit": sf.Fit([law], folder, ""), "Gradient": found.adjoint(np.ones_like(found.displacement)),
    }


def defaults(of: dict[str, Any]) -> dict[str, Any]:
    """Good values by the name of an argument."""
    body, mesh, found = of["Solver"], of["Mesh"], of["Equilibrium"]
    return {
        **vars(of["Inputs"]), **vars(of["Gradient"]), "nodes": mesh.nodes, "elements": mesh.elements, "case": of["Case"], "mesh": mesh, "materials": of["Material"], "clamped": mesh.nodes[:, 0] == 0,
        "size": (1.0, 1.0, 1.0), "cells": (2, 2, 2), "path": EXAMPLES / "finger.msh", "unit": "mm", "source": EXAMPLES / "finger.toml", "text": "gravity = 3",
        "dloss_du": np.ones_like(found.displacement), "at": found, "faces": mesh.skin[:3], "traction": [0.0, 0.0, 1.0], "output": "marker.tip",
        "wrt": ["E.region_0"], "snapshots": np.stack([found.displacement]), "state": of["ReducedState"], "name": "marker.tip", "chamber": 0,
        "displacement": found.displacement, "solver": body, "states": (of["ReducedState"], of["ReducedState"]), "loss": of["ReducedState"],
        "steps": 2, "step": 1e-3, "youngs_modulus": 1e5, "poissons_ratio": 0.3, "body": EXAMPLES / "nowhere.stl", "edge": 0.01, "film": "nowhere.mp4",
        "page": "nowhere.toml", "columns": 5, "rows": 4, "square": 0.01, "folder": ".", "tolerance": 1e-6, "pressures": {"air": 1e3}, "timeout": 10.0,
        "coordinates": np.zeros(2), "velocity": np.zeros(2), "core": of["ReducedModel"]._core, "stage": "mesh",
    }


def signatures(of: dict[str, Any]) -> list[tuple[str, Callable[..., Any]]]:
    """Every public callable: functions, constructors, methods of the subjects, and class methods of the others."""
    calls: list[tuple[str, Callable[..., Any]]] = [(f"mosaic.{one.__name__}", one) for one in (mosaic.apply, mosaic.vector_jacobian_product)]
    for name in sf.__all__:
        thing = getattr(sf, name)
        if isinstance(thing, type):
            if not issubclass(thing, Exception):
                calls.append((name, thing))
            for method, member in inspect.getmembers(of.get(name, thing), callable):
                if not method.startswith("_") and (name in of or inspect.ismethod(member)):
                    calls.append((f"{name}.{method}", member))
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


#: Limits that a call does not reach, and what only says how it is done.
UNSEEN = {"timeout", "max_iterations", "max_cutbacks", "memory", "threads", "quiet", "load_steps", "progress", "tolerance", "kept"}


def same(one: Any, other: Any) -> bool:
    """Whether two results are the same numbers; of what holds none it cannot be said."""
    if isinstance(one, np.ndarray):
        return np.array_equal(one, other)
    if isinstance(one, tuple | list):
        return bool(one) and all(same(a, b) for a, b in zip(one, other, strict=True))
    if dataclasses.is_dataclass(one):
        return all(same(getattr(one, field.name), getattr(other, field.name)) for field in dataclasses.fields(one))
    return isinstance(one, sf.Equilibrium | sf.Motion) and np.array_equal(one.displacement, other.displacement) and repr(one) == repr(other)


def judged(call: Callable[..., Any], given: dict[str, Any], plain: dict[str, Any]) -> tuple[str, str]:
    """What comes of a call, in a word and with its message; `plain` are its arguments without bad ones that may be left out."""
    try:
        result = call(**given)
        has_no_effect = given is not plain and same(result, call(**plain))
        return ("without effect", repr(result)[:200]) if has_no_effect else ("returned", "")
    except sf.InternalError as error:
        return "panic", str(error)
    except sf.Error as error:
        return "typed" if error.what and error.why and error.action else "untyped", str(error)
    except ZeroDivisionError:
        # a callback's own
        return "typed", ""
    except BaseException as error:
        return "untyped", f"{type(error).__name__}: {error}"


def outcome(call: Callable[..., Any], given: dict[str, Any], queue: Any) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.stderr = sys.stdout = open(os.devnull, "w")  # noqa: SIM115
    parameters = inspect.signature(call).parameters
    bad = {key for key in given if parameters[key].default is not inspect.Parameter.empty and given[key] is not parameters[key].default}
    # an empty dictionary gives nothing
    bad = {key for key in bad - UNSEEN if not (isinstance(given[key], dict) and not given[key])}
    plain = {key: value for key, value in given.items() if key not in bad}
    queue.put(judged(call, given, given if plain.keys() == given.keys() else plain))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="each call is made in a fork")
def test_bad_calls_have_a_typed_error_or_a_result(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    of = subjects(tmp_path)
    calls, good = signatures(of), defaults(of)
    context, generator = multiprocessing.get_context("fork"), np.random.default_rng(SEED)
    wrong, counts = [], {"typed": 0, "returned": 0}
    order = np.concatenate([generator.permutation(len(calls)) for _ in range(1 + COUNT // len(calls))])
    for n in order[:COUNT]:
        name, call = calls[n]
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
        if kind not in ("typed", "returned"):
            bad = {key: repr(value)[:60] for key, value in given.items() if value is not good.get(key)}
            wrong.append(f"{name}({bad}): {kind} {said[:200]}")
    print(f"{COUNT} calls of {len(calls)} signatures: {counts}")
    assert not wrong, "\n".join(wrong)
    assert counts["typed"] > COUNT / 3 and counts["returned"] > 0
