"""Records that another program wrote are read as tables and arrays."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import softfish as sf
from conftest import SOURCE


@pytest.fixture
def project(tmp_path: Path) -> Path:
    polars = pytest.importorskip("polars")
    folder = tmp_path / "data" / "processed" / "identify" / "tail" / "record"
    folder.mkdir(parents=True)
    (tmp_path / "study.toml").write_text("")
    polars.DataFrame({"level": [0.0, 1.0], "tip_m": [0.0, 2e-3]}).write_parquet(folder / "levels.parquet")
    (folder / "moduli.json").write_text(json.dumps({"body": 1.6e5}))
    return tmp_path


def test_a_record_gives_its_tables_arrays_and_scalars(project: Path) -> None:
    record = sf.Project(project).record("identify", specimen="tail", stale=True)
    assert record.tables == ["levels"] and record.scalars()["body"] == 1.6e5
    assert record.table()["tip_m"].to_list() == [0.0, 2e-3]
    assert np.array_equal(record.arrays("levels")["level"], [0.0, 1.0])


def test_a_record_that_is_not_of_the_present_cards_is_refused(project: Path) -> None:
    with pytest.raises(sf.InputError, match="there is no specimen"):
        sf.Project(project).record("identify", "tail")
    card = project / "data" / "raw" / "fish" / "specimen.toml"
    card.parent.mkdir(parents=True)
    source = SOURCE.parent
    shutil.copy(source / "study" / "tests" / "card.toml", card)
    shutil.copy(source.parent / "study.toml", project / "study.toml")
    mesh = project / "data" / "processed" / "mesh"
    mesh.mkdir()
    (project / "data" / "processed" / "identify" / "tail").rename(mesh / "fish")
    with pytest.raises(sf.InputError, match="is not up to date"):
        sf.Project(project).record("mesh", "fish")
    text = card.read_text()
    card.write_text(text.replace("length = 0.1", "length = -0.1"))
    with pytest.raises(sf.InputError, match="specimen.toml"):
        sf.Project(project).record("mesh", "fish")
    assert sf.Project(project).record("mesh", "fish", stale=True).tables == ["levels"]


def test_a_record_that_is_not_there_says_which_are(project: Path) -> None:
    with pytest.raises(sf.InputError, match="identify/tail"):
        sf.Project(project).record("identify", specimen="fin")
    with pytest.raises(sf.InputError, match="levels.parquet"):
        sf.Project(project).record("identify", "tail", stale=True).table("nothing")
    with pytest.raises(sf.InputError, match="`profile` is 'slow'"):
        sf.Project(project, "slow")  # type: ignore[arg-type]
    with pytest.raises(sf.InputError, match="is no project"):
        sf.Project(project / "data")
