"""The dictionaries that the compiled part takes and returns: flat arrays, in the order of nodes, elements and steps."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias, TypedDict

from softfish._arrays import Array, IntArray

#: Of a copied mesh: the region of each element, code and nodes of each face of the skin, and tag, name, elements and volume (m³) of each region.
SolidParts: TypeAlias = tuple[list[int], list[int], list[list[int]], list[tuple[int, "str | None", int, float]]]

if TYPE_CHECKING:
    from softfish._core import Trajectory


class Inputs(TypedDict):
    """What a solve depends on."""

    youngs_modulus: Array
    poissons_ratio: Array
    density: Array
    factors: Array
    forces: Array
    gravity: Array


class Materials(TypedDict):
    """What the regions are made of, region by region."""

    law: list[str]
    youngs_modulus: list[float]
    poissons_ratio: list[float]
    density: list[float]
    mean_dilatation: list[bool]
    lumped_mass: bool


class StaticSettings(TypedDict):
    """Settings of an equilibrium."""

    tolerance: float
    load_steps: int
    reuse_factor: bool
    max_iterations: int | None
    max_cutbacks: int | None
    timeout: float | None


class DynamicSettings(TypedDict):
    """Settings of a motion."""

    step: float
    scheme: str
    mass_damping: float
    stiffness_damping: float
    tolerance: float
    memory: int
    max_iterations: int | None
    timeout: float | None


class Direction(TypedDict):
    """So much of each parameter."""

    youngs_modulus: list[float]
    poissons_ratio: list[float]
    density: list[float]
    factors: Array
    pressures: list[float]
    forces: Array


class FoundEquilibrium(TypedDict):
    """An equilibrium."""

    displacement: Array
    pressures: Array
    iterations: int
    factorisations: int
    residual: float
    snap_through: list[float]


class _FoundMotion(TypedDict):
    """A motion."""

    times: Array
    displacement: Array
    velocity: Array


class FoundMotion(_FoundMotion, total=False):
    """With what its gradient needs, and the pressures of adaptive steps."""

    trajectory: Trajectory
    pressures: Array


class FoundPath(TypedDict):
    """A path of equilibria."""

    levels: Array
    displacement: Array
    negative_eigenvalues: IntArray
    eigenvalues: Array
    iterations: IntArray
    critical: list[tuple[bool, float, Array, Array]]


class _FoundGradient(TypedDict):
    """A gradient."""

    youngs_modulus: Array
    poissons_ratio: Array
    density: Array
    factors: Array
    pressures: Array
    forces: Array


class FoundGradient(_FoundGradient, total=False):
    """With keys that may be absent."""

    mass_damping: float
    stiffness_damping: float
    initial_displacement: Array
    initial_velocity: Array


class CaseDynamic(TypedDict):
    """Settings of a motion in a case."""

    duration: float
    step: float | None
    scheme: str
    mass_damping: float
    stiffness_damping: float
    #: Tolerance (m), shortest and longest step (s).
    adaptive: tuple[float, float, float] | None
    starts_at_rest: bool


class _CaseData(TypedDict):
    """What a case says."""

    forces: Array
    gravity: Array
    chambers: list[tuple[str, int]]
    points: list[tuple[str, IntArray, Array]]
    notes: list[str]


class CaseData(_CaseData, total=False):
    """With keys that may be absent."""

    levels: list[float]
    load_steps: int
    tolerance: float
    follows_path: bool
    #: Iterations, cut-backs, seconds.
    budget: tuple[int | None, int | None, float | None]
    dynamic: CaseDynamic


class ReducedData(TypedDict):
    """What a reduced model is restored from."""

    modes: Array
    points: list[tuple[list[int], list[float]]]
    size: float


class BoxMesh(TypedDict):
    """A mesh of a box."""

    nodes: Array
    elements: IntArray
    each: int


class MeshedSurfaces(TypedDict):
    """A mesh of quadratic tetrahedra that surfaces enclose."""

    nodes: Array
    elements: IntArray
    regions: IntArray
    repairs: list[str]


class FilmAsked(TypedDict):
    """What is asked of a film."""

    film: str
    at: list[list[float]]
    find: int | None
    region: list[float] | None
    radius: float
    hidden: float
    first: int
    last: int | None
    overlay: bool
    out: str | None


class FoundTracks(TypedDict):
    """Markers of a film."""

    first: int
    time: Array
    position: Array
    covariance: Array
    residual: Array
    seen: list[bool]


class BoardAsked(TypedDict):
    """What is asked of pictures of a board."""

    source: str
    columns: int
    rows: int
    square: float
    dots: bool
    fisheye: bool
    every: int
    out: str | None


class FoundCamera(TypedDict):
    """A calibrated camera."""

    fisheye: bool
    size: tuple[int, int]
    mean: Array
    covariance: Array
    reprojection_error: float
    views: list[str]
    errors: Array
    rotation: Array
    translation: Array
