"""Reduced tails: their steps, states and refusals, and a stepper written from their page alone."""

from __future__ import annotations

import copy
import json
import pickle
from pathlib import Path

import numpy as np
import pytest
import softfish as sf

RATE = 240.0


def pressures(n: int) -> np.ndarray:
    """Of step n, Pa: one chamber, then the other."""
    wave = np.sin(2 * np.pi * 2.0 * n / RATE)
    return 2e4 * np.array([max(wave, 0.0), max(-wave, 0.0)])


def arrays(path: Path) -> dict[str, np.ndarray]:
    """The arrays of a file of safetensors."""
    content = path.read_bytes()
    length = int.from_bytes(content[:8], "little")
    header = json.loads(content[8 : 8 + length])
    header.pop("__metadata__")
    data = content[8 + length :]
    return {n: np.frombuffer(data[slice(*a["data_offsets"])], "<f8").reshape(a["shape"]) for n, a in header.items()}


class Stranger:
    """The equations and the integrator of the page, in numpy."""

    def __init__(self, a: dict[str, np.ndarray], step: float) -> None:
        self.a, self.h, self.r = a, step, len(a["mass"])
        self.regions = [i for i in range(99) if f"region{i}.moduli" in a]
        self.chambers = [i for i in range(99) if f"chamber{i}.linear" in a]
        self.past = [(np.zeros(self.r), np.zeros(self.r), np.zeros(self.r))]
        self.stress = {i: np.zeros((len(a[f"region{i}.weights"]), 3, 3)) for i in self.regions}
        self.over = {i: np.zeros((len(a[f"region{i}.branches"]), *self.stress[i].shape)) for i in self.regions}

    def rate(self, now: np.ndarray, kind: int) -> np.ndarray:
        if len(self.past) == 1:
            return (now - self.past[0][kind]) / self.h
        return (3 * now - 4 * self.past[0][kind] + self.past[1][kind]) / (2 * self.h)

    def deformation(self, i: int, q: np.ndarray) -> np.ndarray:
        change = np.einsum("pmk,m->pk", self.a[f"region{i}.gradients"], q).reshape(-1, 3, 3)
        return np.eye(3) + change.transpose(0, 2, 1)  # columns of F in turn

    def branches(self, i: int) -> tuple[np.ndarray, np.ndarray]:
        strength, time = self.a[f"region{i}.branches"].T
        decay = np.exp(-self.h / time)
        return decay, strength * (1 - decay) * time / self.h

    def relaxed(self, i: int, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        f = self.deformation(i, q)
        stress = np.eye(3) - np.linalg.inv(f.transpose(0, 2, 1) @ f)
        decay, gain = self.branches(i)
        over = decay[:, None, None, None] * self.over[i] + gain[:, None, None, None] * (stress - self.stress[i])
        return stress, over

    def elastic(self, i: int, q: np.ndarray) -> np.ndarray:
        f, (mu, lam, c20, c30) = self.deformation(i, q), self.a[f"region{i}.moduli"]
        inverse = np.linalg.inv(f).transpose(0, 2, 1)
        log = np.log(np.linalg.det(f))
        x = np.einsum("pij,pij->p", f, f) - 3 - 2 * log
        p = (mu + 4 * c20 * x + 6 * c30 * x**2)[:, None, None] * (f - inverse) + (lam * log)[:, None, None] * inverse
        p = p + f @ (mu * self.relaxed(i, q)[1].sum(0))
        entries = p.transpose(0, 2, 1).reshape(-1, 9)
        return np.einsum("p,pmk,pk->m", self.a[f"region{i}.weights"], self.a[f"region{i}.gradients"], entries)

    def volume_slope(self, i: int, q: np.ndarray) -> np.ndarray:
        linear, quadratic, cubic = (self.a[f"chamber{i}.{part}"] for part in ("linear", "quadratic", "cubic"))
        full, (rows, columns) = np.zeros((self.r, self.r, self.r)), np.triu_indices(self.r)
        full[rows, columns] = full[columns, rows] = cubic
        return linear + quadratic @ q + 0.5 * np.einsum("ijk,i,j->k", full, q, q)

    def water(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        slope, value, (mass, drag, shed, leaving) = self.a["sections.slope"], self.a["sections.value"], self.a["sections.by"].T
        t = slope @ q + np.array([1.0, 0.0])
        n, speed = np.stack([-t[:, 1], t[:, 0]], 1), value @ v
        w, u = (speed * n).sum(1), (speed * t).sum(1)
        flux = (u * w)[:, None] * n - (0.5 * w * w)[:, None] * t
        momentum = np.einsum("skm,sk->m", value, (mass * w)[:, None] * n)
        push = np.einsum("skm,sk->m", value, leaving[:, None] * flux - (drag * abs(w) * w)[:, None] * n)
        return momentum, push - np.einsum("skm,sk->m", slope, shed[:, None] * flux)

    def residual(self, q: np.ndarray, p: np.ndarray) -> np.ndarray:
        v = self.rate(q, 0)
        force = self.a["mass"] @ self.rate(v, 1) + sum(self.elastic(i, q) for i in self.regions)
        momentum, water = self.water(q, v)
        return force - sum(p[i] * self.volume_slope(i, q) for i in self.chambers) + self.rate(momentum, 2) - water

    def step(self, p: np.ndarray) -> np.ndarray:
        q, small = self.past[0][0].copy(), 1e-7 * self.a["size"][0]
        for _ in range(50):
            slopes = [(self.residual(q + small * e, p) - self.residual(q - small * e, p)) / (2 * small) for e in np.eye(self.r)]
            change = np.linalg.solve(np.array(slopes).T, self.residual(q, p))
            q = q - change
            if abs(change).max() < 1e-10 * self.a["size"][0]:
                break
        v = self.rate(q, 0)
        for i in self.regions:
            self.stress[i], self.over[i] = self.relaxed(i, q)
        self.past = [(q, v, self.water(q, v)[0]), self.past[0]]
        return self.a["outputs"] @ q


@pytest.mark.parametrize("water", [False, True])
def test_a_stepper_written_from_the_page_moves_the_same(tmp_path: Path, water: bool) -> None:
    tail = sf.Twin.example(water=water)
    tail.write(tmp_path / "tail.safetensors")
    stranger, state, reach = Stranger(arrays(tmp_path / "tail.safetensors"), 1 / RATE), tail.start(), 0.0
    for n in range(1, 61):
        state.step(pressures(n), 1 / RATE)
        theirs = stranger.step(pressures(n))
        assert np.abs(theirs - list(state.outputs.values())).max() < 1e-6 * 0.1
        reach = max(reach, abs(state.outputs["tip_y"]))
    assert reach > 1e-3
    assert "implicit Euler" in tail.page and "tip_y" in tail.page


def test_what_the_file_says_is_at_hand() -> None:
    tail = sf.Twin.example()
    assert tail.chambers == {"left": (0.0, 8e4), "right": (0.0, 8e4)}
    assert tail.outputs == {"tip_x": 0.1, "tip_y": 0.0} and tail.regions == ("rubber",) and not tail.half
    assert tail.provenance["example"] and "7 coordinates" in repr(tail)


def test_states_and_tails_are_copied_pickled_and_saved() -> None:
    tail = sf.Twin.example(water=True)
    state = tail.start()
    for n in range(20):
        state.step({"left": 1e3 * n}, 1e-3)
    others = [copy.deepcopy(state), copy.copy(state), pickle.loads(pickle.dumps(state)), tail.restored(state.saved())]
    for one in [state, *others]:
        one.step({"right": 5e3}, 1e-3)
    assert all(np.array_equal(one.coordinates, state.coordinates) for one in others)
    assert state.volumes["left"] > 0 and state.time == pytest.approx(0.021) and len(state.velocity) == tail.coordinates


def test_refusals_name_what_was_wrong_and_leave_the_state_as_it_was(tmp_path: Path) -> None:
    state = sf.Twin.example().start()
    state.step({"left": 1e4}, 1e-3)
    before = state.coordinates
    for pressure, words in [({"left": 1e6}, "12.5 times"), ({"left": -1e4}, "`left`"), ({"middle": 1.0}, "left, right"), ([1.0], "shape")]:
        with pytest.raises(sf.InputError, match=words):
            state.step(pressure, 1e-3)
    with pytest.raises(sf.Error):
        state.step({"left": 1e4}, 0.0)
    with pytest.raises(sf.InputError, match="saved"):
        state.twin.restored(b"other")
    with pytest.raises(sf.Error):
        sf.Twin(tmp_path / "none.safetensors")
    assert np.array_equal(state.coordinates, before)
