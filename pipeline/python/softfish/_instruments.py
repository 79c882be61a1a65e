"""Instruments by themselves: markers tracked through a film, and a camera calibrated from pictures of a board."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from softfish import _core
from softfish._arguments import checked
from softfish._arrays import Array, file, reals, whole
from softfish._errors import InputError

_Path: TypeAlias = "str | os.PathLike[str]"


@dataclass(frozen=True)
class Tracks:
    """Markers in every frame of a film.

    Attributes:
        frames: Number of each frame in the film.
        time: Of each frame, s.
        position: Markers × frames × 2: u to the right and v down, the centre of the first pixel at 0, 0; px.
        covariance: Of the position, markers × frames × 2 × 2, px².
        residual: Mean difference from the marker of the first frame: markers × frames, grey levels a pixel.
        seen: Whether it was seen; where not, its position is interpolated: markers × frames.
    """

    frames: npt.NDArray[np.int64]
    time: Array
    position: Array
    covariance: Array
    residual: Array
    seen: npt.NDArray[np.bool_]


@checked()
def track(
    film: _Path,
    *,
    at: npt.ArrayLike | None = None,
    find: int | None = None,
    region: Sequence[float] | None = None,
    radius: float = 18.0,
    hidden: float = 0.5,
    first: int = 0,
    last: int | None = None,
    overlay: bool = False,
    out: _Path | None = None,
) -> Tracks:
    """Tracks markers through a film, as `study track` does: H.264 in MP4, a folder of pictures with `times.csv`, or what an ffmpeg on the
    PATH reads.

    Either `at` places them in the first frame (markers × 2, px), or so many dark spots are to `find`, in a `region` (left, top, right,
    bottom, px) or the whole picture. `radius` is that of the disc which holds a marker and a margin of light ground (px), `hidden` the
    longest occlusion (s). Results are written into the folder `out` where one is given, with `overlay` a film of them too."""
    if (find is None) == (at is None):
        raise InputError("the markers of the first frame are not given", "they are placed or detected", "give at or find")
    if region is not None and find is None:
        raise InputError("`region` has no effect", "the markers are placed, not detected", "give find in the place of at")
    if overlay and out is None:
        raise InputError("an overlay has no folder", "it is a file among the results", "give out")
    places = np.zeros((0, 2)) if at is None else np.atleast_2d(reals("at", at))
    if at is not None and (len(places) == 0 or places.shape[1:] != (2,)):
        raise InputError(f"`at` has the shape {places.shape}", "each row is a marker: u and v, px", "pass markers × 2")
    found = _core.track({
        "film": os.fspath(film),
        "at": places.tolist(),
        "find": find,
        "region": None if region is None else reals("region", region, (4,)).tolist(),
        "radius": radius,
        "hidden": hidden,
        "first": first,
        "last": None if last is None else whole("last", last, first, 1 << 40),
        "overlay": overlay,
        "out": None if out is None else os.fspath(out),
    })
    count = len(found["time"])
    seen = np.array(found["seen"], dtype=bool).reshape(-1, count)
    return Tracks(
        frames=found["first"] + np.arange(count, dtype=np.int64),
        time=found["time"],
        position=found["position"].reshape(-1, count, 2),
        covariance=found["covariance"].reshape(-1, count, 2, 2),
        residual=found["residual"].reshape(-1, count),
        seen=seen,
    )


@dataclass(frozen=True)
class Camera:
    """A calibrated camera.

    Attributes:
        fisheye: Whether its lens is a fisheye (k1 to k4); else distortion is Brown and Conrady's (k1, k2, p1, p2, k3).
        size: Width and height of its pictures, px.
        mean: fx, fy, cx, cy (px), then the coefficients of distortion in OpenCV's order (no unit): one per parameter.
        covariance: Of the mean: parameters × parameters, px² and no unit as there.
        reprojection_error: Root of the mean squared distance between seen and projected points of the board, px.
        views: Name of each picture of the whole board, or time of each frame.
        errors: Reprojection error of each view, px.
        rotation: From the board to the camera: views × 3 × 3, no unit.
        translation: From the board to the camera: views × 3, m.
    """

    fisheye: bool
    size: tuple[int, int]
    mean: Array
    covariance: Array
    reprojection_error: float
    views: list[str]
    errors: Array
    rotation: Array
    translation: Array

    @property
    def matrix(self) -> Array:
        """3 × 3, as `cv2` takes it, px."""
        fx, fy, cx, cy = self.mean[:4]
        return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])

    @property
    def distortion(self) -> Array:
        """Its coefficients, one per parameter, as `cv2` takes them, no unit."""
        return self.mean[4:]


@checked(source=file)
def calibrate(
    source: _Path,
    *,
    columns: int,
    rows: int,
    square: float,
    dots: bool = False,
    fisheye: bool = False,
    every: int = 10,
    out: _Path | None = None,
) -> Camera:
    """Calibrates a camera from a film or a folder of PNG or JPEG pictures of a board, as `study calibrate` does.

    `columns` and `rows` count the board's squares, or its `dots`; `square` is a side, or the distance of the dots' middles (m). Of a film one
    frame in `every` is used. Results are written into the folder `out` where one is given."""
    found = _core.calibrate({
        "source": os.fspath(source),
        "columns": columns,
        "rows": rows,
        "square": square,
        "dots": dots,
        "fisheye": fisheye,
        "every": every,
        "out": None if out is None else os.fspath(out),
    })
    count = len(found["mean"])
    return Camera(
        fisheye=found["fisheye"],
        size=found["size"],
        mean=found["mean"],
        covariance=found["covariance"].reshape(count, count),
        reprojection_error=found["reprojection_error"],
        views=found["views"],
        errors=found["errors"],
        rotation=found["rotation"].reshape(-1, 3, 3),
        translation=found["translation"].reshape(-1, 3),
    )
