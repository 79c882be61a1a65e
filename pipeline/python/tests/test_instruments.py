"""Tracks and cameras: known motions and a known lens come back, with the files of the command line to the byte."""

from __future__ import annotations

import struct
import subprocess
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import interrupted, program

import softfish as sf

SIZE = (320, 200)


def write_png(path: Path, picture: np.ndarray) -> None:
    """Grey levels (rows × columns) as a PNG."""
    rows, columns = picture.shape
    levels = np.clip(np.round(picture), 0, 255).astype(np.uint8)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    lines = b"".join(b"\0" + row.tobytes() for row in levels)
    head = struct.pack(">IIBBBBB", columns, rows, 8, 0, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(lines, 1)) + chunk(b"IEND", b""))


def places(frame: int) -> np.ndarray:
    """Of two marks, px."""
    return np.array([[80.0 + 2.3 * frame, 60.0 + 8.0 * np.sin(0.3 * frame)], [150.0 + 1.7 * frame, 130.0]])


@pytest.fixture
def film(tmp_path: Path) -> Path:
    folder = tmp_path / "film"
    folder.mkdir()
    v, u = np.mgrid[: SIZE[1], : SIZE[0]]
    for frame in range(24):
        picture = 200.0 + 10.0 * np.sin(0.05 * u) + 5.0 * np.cos(0.07 * v)
        for at in places(frame):
            edge = np.clip(7.5 - np.hypot(u - at[0], v - at[1]), 0.0, 1.0)
            picture = picture + edge * (40.0 - picture)
        write_png(folder / f"{frame:03}.png", picture)
    (folder / "times.csv").write_text("\n".join(f"{frame / 60:.6f}" for frame in range(24)), encoding="utf-8")
    return folder


def test_known_motions_come_back_with_the_file_of_the_command_line(film: Path, tmp_path: Path) -> None:
    found = sf.track(film, find=2, out=tmp_path / "python", first=2, last=20)
    truth = np.array([places(frame) for frame in range(2, 21)]).transpose(1, 0, 2)
    assert found.position.shape == (2, 19, 2) and found.covariance.shape == (2, 19, 2, 2)
    assert np.abs(found.position - truth).max() < 0.1 and found.seen.all() and np.array_equal(found.frames, np.arange(2, 21))
    assert np.allclose(found.time, found.frames / 60, atol=1e-6) and (np.linalg.eigvalsh(found.covariance) > 0.0).all()
    study = program()
    if study is None:
        pytest.skip("the program study is not built")
    words = ["track", film, "--find", "2", "--first", "2", "--last", "20", "--out", tmp_path / "cli"]
    subprocess.run([study, *words], check=True, capture_output=True)
    for name in ["tracks.csv", "strip.png"]:
        assert (tmp_path / "cli" / name).read_bytes() == (tmp_path / "python" / name).read_bytes()


def test_without_a_folder_nothing_is_written(film: Path) -> None:
    before = sorted(film.parent.rglob("*"))
    found = sf.track(film, at=places(0))
    assert found.position.shape == (2, 24, 2) and sorted(film.parent.rglob("*")) == before


@pytest.mark.parametrize("arguments, word", [
    ({}, "at or find"),
    ({"at": [[1.0, 2.0, 3.0]]}, "shape"),
    ({"find": 0}, "find"),
    ({"find": "two"}, "find"),
    ({"find": 9}, "of 9 markers"),
    ({"at": [[300.0, 20.0]]}, "marker"),
    ({"find": 2, "radius": 2.0}, "radius"),
    ({"find": 2, "first": 30}, "24 frames"),
    ({"find": 2, "first": 5, "last": 4}, "last"),
    ({"find": 2, "overlay": True}, "folder"),
    ({"find": 2, "hidden": np.nan}, "finite"),
])
def test_what_cannot_be_tracked_is_refused(film: Path, arguments: dict[str, Any], word: str) -> None:
    with pytest.raises(sf.InputError, match=word) as caught:
        sf.track(film, **arguments)
    assert caught.value.what and caught.value.why and caught.value.action


def test_an_interrupt_ends_the_tracking(film: Path) -> None:
    # a film that takes longer than anyone waits: the same picture under many names
    picture = (film / "000.png").read_bytes()
    for frame in range(24, 6000):
        (film / f"{frame:05}.png").write_bytes(picture)
    (film / "times.csv").write_text("\n".join(f"{frame / 60:.6f}" for frame in range(6000)), encoding="utf-8")
    for frame in range(24):
        (film / f"{frame:03}.png").rename(film / f"{frame:05}.png")
        (film / f"{frame:05}.png").write_bytes(picture)
    with interrupted(0.5):
        sf.track(film, find=2)


LENS = np.array([[450.0, 0.0, 322.0], [0.0, 452.0, 178.0], [0.0, 0.0, 1.0]])
SQUARE = 0.02


def view(tilt: tuple[float, float]) -> np.ndarray:
    """A board of 9 × 6 squares, tilted about both axes (rad), 0.3 m before a camera without distortion."""
    (a, b), middle = tilt, np.array([0.07, 0.04, 0.0])
    about_u = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    about_v = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    turn = about_v @ about_u
    shift = np.array([0.0, 0.0, 0.3]) - turn @ middle
    to_board = np.linalg.inv(LENS @ np.column_stack([turn[:, 0], turn[:, 1], shift]))
    fine = (np.arange(4) + 0.5) / 4 - 0.5
    v, u = np.mgrid[:360, :640].astype(float)
    light = np.zeros_like(u)
    for du in fine:
        for dv in fine:
            x, y, w = np.tensordot(to_board, np.stack([u + du, v + dv, np.ones_like(u)]), 1)
            i, j = np.floor(x / w / SQUARE) + 1, np.floor(y / w / SQUARE) + 1
            dark = (i >= 0) & (i < 9) & (j >= 0) & (j < 6) & ((i + j) % 2 == 0)
            light += np.where(dark, 30.0, 220.0) / 16
    return light


def test_a_known_lens_comes_back_with_the_files_of_the_command_line(tmp_path: Path) -> None:
    folder = tmp_path / "board"
    folder.mkdir()
    for k, tilt in enumerate([(0.0, 0.0), (0.4, 0.1), (-0.4, 0.0), (0.1, 0.4), (0.0, -0.4), (0.3, 0.3)]):
        write_png(folder / f"{k}.png", view(tilt))
    camera = sf.calibrate(folder, columns=9, rows=6, square=SQUARE, out=tmp_path / "python")
    deviations = np.sqrt(np.diag(camera.covariance))
    assert len(camera.views) == 6 and camera.size == (640, 360) and camera.reprojection_error < 0.1
    assert np.abs(camera.matrix - LENS).max() < 2.0 and np.all(np.abs(camera.mean - [450, 452, 322, 178, 0, 0, 0, 0, 0]) < 6 * deviations)
    assert camera.distortion.shape == (5,) and np.allclose(np.linalg.norm(camera.translation, axis=1), 0.3, atol=0.1)
    assert np.allclose(camera.rotation @ camera.rotation.transpose(0, 2, 1), np.eye(3), atol=1e-9)
    study = program()
    if study is None:
        pytest.skip("the program study is not built")
    words = ["calibrate", folder, "--columns", "9", "--rows", "6", "--square", str(SQUARE), "--out", tmp_path / "cli"]
    subprocess.run([study, *words], check=True, capture_output=True)
    for name in ["camera.toml", "camera.yaml", "views.csv", "camera.svg"]:
        assert (tmp_path / "cli" / name).read_bytes() == (tmp_path / "python" / name).read_bytes()


@pytest.mark.parametrize("arguments, word", [
    ({"columns": 2}, "columns"),
    ({"square": 20.0}, "square"),
    ({"every": 0}, "every"),
    ({"rows": 6.5}, "rows"),
    ({"source": "nowhere"}, "nowhere"),
])
def test_what_cannot_be_calibrated_is_refused(film: Path, arguments: dict[str, Any], word: str) -> None:
    with pytest.raises(sf.InputError, match=word):
        sf.calibrate(**{"source": film, "columns": 9, "rows": 6, "square": 0.02, **arguments})
