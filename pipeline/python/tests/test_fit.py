"""Identification from recordings: what is refused, and the real bar where its recordings are."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from conftest import SOURCE

import softfish as sf

PROJECT = SOURCE.parents[1]
RECORDINGS = [PROJECT / "data/raw/beam_ds10", PROJECT.parent / "shared/real/beam_ds10"]


def test_recordings_that_are_not_there_are_named(tmp_path: Path) -> None:
    page = SOURCE.parent / "sysid/examples/real/beam_ds10.toml"
    with pytest.raises(sf.InputError, match="gravity_a.csv"):
        sf.fit(page, root=tmp_path, out=tmp_path)
    with pytest.raises(sf.InputError):
        sf.fit(tmp_path / "nowhere.toml")


HERE = any((folder / "gravity_a.csv").exists() for folder in RECORDINGS)


@pytest.mark.skipif(not (HERE and os.environ.get("SOFTFISH_REAL")), reason="minutes long: SOFTFISH_REAL=1, with the recordings")
def test_the_modulus_of_the_real_bar_is_found_with_its_covariance(tmp_path: Path) -> None:
    found = sf.fit("beam_ds10", root=PROJECT, out=tmp_path)
    assert found.parameters[0] == "youngs_modulus" and 2e5 < found.mean[0] < 3.5e5
    assert found.covariance.shape == (len(found.mean),) * 2 and np.all(np.linalg.eigvalsh(found.covariance) > 0.0)
    assert (tmp_path / "real_beam_ds10.csv").exists() and "beam_ds10" in found.report
