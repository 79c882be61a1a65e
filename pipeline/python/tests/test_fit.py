"""Identification from recordings: what is refused, and the real bar where its recordings are."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from conftest import SOURCE, interrupted

import softfish as sf

PROJECT = SOURCE.parents[1]
RECORDINGS = [PROJECT / "data/raw/beam_ds10", PROJECT.parent / "shared/real/beam_ds10"]


def test_recordings_that_are_not_there_are_named(tmp_path: Path) -> None:
    page = SOURCE.parent / "sysid/examples/real/beam_ds10.toml"
    with pytest.raises(sf.InputError, match="gravity_a.csv"):
        sf.fit(page, root=tmp_path, out=tmp_path)
    with pytest.raises(sf.InputError):
        sf.fit(tmp_path / "nowhere.toml")


def test_an_interrupt_ends_a_fit(tmp_path: Path) -> None:
    folder = tmp_path / "data/raw/beam_ds10"
    folder.mkdir(parents=True)
    markers = {"tip_top": (0.1, 0.015, 0.036), "tip_left": (0.1, -0.006, 0.024), "tip_right": (0.1, 0.036, 0.006),
               "base_1": (0.006, -0.01, -0.001), "base_2": (0.006, 0.04, 0.0275), "base_3": (0.006, 0.04, 0.0)}
    lines = ["time_s,marker,x_m,y_m,z_m"]
    for t in np.arange(0.0, 6.0, 0.01):
        s = max(t - 0.6, 0.0)
        fall = -0.01 * (1.0 - np.exp(-1.5 * s) * np.cos(25.0 * s))
        lines += [f"{t:.4f},{name},{x},{y},{z + (fall if name.startswith('tip') else 0.0):.6f}" for name, (x, y, z) in markers.items()]
    for name in ["gravity_a", "gravity_b", "load52_a", "load52_b"]:
        (folder / f"{name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    with interrupted(4.0):
        sf.fit(SOURCE.parent / "sysid/examples/real/beam_ds10.toml", root=tmp_path, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_the_page_of_an_inflation_test_is_named_as_such() -> None:
    with pytest.raises(sf.InputError, match="inflation test"):
        sf.fit("arm_ds10", root=PROJECT)


HERE = any((folder / "gravity_a.csv").exists() for folder in RECORDINGS)


@pytest.mark.skipif(not (HERE and os.environ.get("SOFTFISH_REAL")), reason="minutes long: SOFTFISH_REAL=1, with the recordings")
def test_the_modulus_of_the_real_bar_is_found_with_its_covariance(tmp_path: Path) -> None:
    found = sf.fit("beam_ds10", root=PROJECT, out=tmp_path)
    assert found.parameters[0] == "youngs_modulus" and 2e5 < found.mean[0] < 3.5e5
    assert found.covariance.shape == (len(found.mean),) * 2 and np.all(np.linalg.eigvalsh(found.covariance) > 0.0)
    assert (tmp_path / "real_beam_ds10.csv").exists() and "beam_ds10" in found.report
