"""Further observations of a block: exposure stations, distances, height differences, prior values of parameters.

Each table is empty where nothing was observed. Conventions as in simfield.block.block: metres, radians, NaN for what
was not observed; rows name images, points and cameras by their index.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, fields, replace

import numpy as np
import numpy.typing as npt

from simfield.block.checks import (
    BlockError,
    Floats,
    Indices,
    check_ids,
    check_index,
    check_shape,
    freeze,
    refuse,
    refuse_weightless,
)

Mask = npt.NDArray[np.bool_]

POSITION = ("X0_m", "Y0_m", "Z0_m")
SIGMA_POSITION = ("sigma_X0_m", "sigma_Y0_m", "sigma_Z0_m")
ATTITUDE = ("omega_deg", "phi_deg", "kappa_deg")
SIGMA_ATTITUDE = ("sigma_omega_deg", "sigma_phi_deg", "sigma_kappa_deg")
BIASES = ("none", "offset", "drift")
"""unknown biases of a strip: none; an offset; an offset and a drift with time"""
ANGLE_MOST = 4.0 * np.pi


def _none(*shape: int) -> Floats:
    return np.empty((0, *shape))


def _no_index() -> Indices:
    return np.empty(0, dtype=np.intp)


@dataclass(frozen=True, eq=False)
class Strips:
    """Strips of observed stations: ids (s), and position and attitude (s), the biases of each, in BIASES."""

    ids: tuple[str, ...] = ()
    position: tuple[str, ...] = ()
    attitude: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.ids)

    def check(self) -> None:
        if not self.ids:
            return
        check_ids("strips", self.ids, "strip_id")
        for column, biases in (("position_bias", self.position), ("attitude_bias", self.attitude)):
            for row, bias in enumerate(biases):
                if bias not in BIASES:
                    raise BlockError("strips", f"{bias!r} is no bias, allowed are {', '.join(BIASES)}", row, column)


@dataclass(frozen=True, eq=False)
class Stations:
    """Observed exposure stations (q): image and strip (q) indices, strip -1 for none; position (q, 3) of the projection
    centre, m, and attitude (q, 3), rad, each with standard deviations, NaN where not observed; time_s (q), NaN where
    the order of the rows is the time.
    """

    image: Indices = field(default_factory=_no_index)
    strip: Indices = field(default_factory=_no_index)
    time_s: Floats = field(default_factory=_none)
    position: Floats = field(default_factory=lambda: _none(3))
    sigma_position: Floats = field(default_factory=lambda: _none(3))
    attitude: Floats = field(default_factory=lambda: _none(3))
    sigma_attitude: Floats = field(default_factory=lambda: _none(3))

    def __post_init__(self) -> None:
        both = dict.fromkeys(("position", "sigma_position", "attitude", "sigma_attitude", "time_s"), np.float64)
        freeze(self, image=np.intp, strip=np.intp, **both)

    def __len__(self) -> int:
        return len(self.image)

    def check(self, images: Sequence[str], strips: Strips) -> None:
        q = len(self)
        check_shape("stations", "strip", self.strip, (q,))
        check_shape("stations", "time_s", self.time_s, (q,))
        check_index("stations", self.image, len(images), "image_id")
        check_index("stations", np.where(self.strip == -1, 0, self.strip), max(len(strips), 1), "strip_id")
        _refuse_twice("stations", [images[i] for i in self.image], "image_id")
        _refuse_infinite("stations", self.time_s[:, None], ("time_s",))
        for values, sigma, columns, sigmas in (
            (self.position, self.sigma_position, POSITION, SIGMA_POSITION),
            (self.attitude, self.sigma_attitude, ATTITUDE, SIGMA_ATTITUDE),
        ):
            check_shape("stations", columns[0], values, (q, 3))
            check_shape("stations", sigmas[0], sigma, (q, 3))
            _refuse_infinite("stations", values, columns)
            _check_sigma("stations", sigma, sigmas, may_be_empty=True)
            _refuse_one_without_other(values, sigma, columns, sigmas)
        angles = np.nan_to_num(np.abs(self.attitude))
        refuse("stations", angles > ANGLE_MOST, ATTITUDE, np.rad2deg(self.attitude), "|angle| <= 720 degrees")
        wide = np.nan_to_num(self.sigma_attitude)
        refuse("stations", wide > ANGLE_MOST, SIGMA_ATTITUDE, np.rad2deg(np.minimum(wide, 1e9)), "<= 720 degrees")
        nothing = np.isnan(self.position).all(axis=1) & np.isnan(self.attitude).all(axis=1)
        if nothing.any():
            raise BlockError("stations", "has neither a position nor an attitude", int(np.argmax(nothing)))
        self._check_strips(strips)

    def _check_strips(self, strips: Strips) -> None:
        """Times are given for all stations of a strip or for none; a drift needs two of them apart."""
        for strip, biases in enumerate(zip(strips.position, strips.attitude, strict=True)):
            rows = np.flatnonzero(self.strip == strip)
            times = self.time_s[rows]
            given = np.isfinite(times)
            if given.any() and not given.all():
                row = int(rows[np.argmin(given)])
                raise BlockError("stations", "is empty while others of its strip are given", row, "time_s")
            apart = len(rows) if not given.any() else len(np.unique(times))
            if not len(rows):
                raise BlockError("strips", f"strip {strips.ids[strip]!r} has no station", strip, "strip_id")
            for column, bias in zip(("position_bias", "attitude_bias"), biases, strict=True):
                if bias == "drift" and apart < 2:
                    raise BlockError("strips", "a drift needs two stations at different times", strip, column)

    def taken(self, rows: Mask | Indices, image: Indices, strip: Indices) -> Stations:
        """The chosen rows, with other indices of images and strips."""
        kept = {f.name: getattr(self, f.name)[rows] for f in fields(self) if f.name not in ("image", "strip")}
        return Stations(image, strip, **kept)


@dataclass(frozen=True, eq=False)
class Lines:
    """Measurements between two points (q): start and end (q) indices of points, values and sigma (q), m."""

    start: Indices = field(default_factory=_no_index)
    end: Indices = field(default_factory=_no_index)
    values: Floats = field(default_factory=_none)
    sigma: Floats = field(default_factory=_none)

    def __post_init__(self) -> None:
        freeze(self, start=np.intp, end=np.intp, values=np.float64, sigma=np.float64)

    def __len__(self) -> int:
        return len(self.start)

    def check(self, table: str, column: str, points: Sequence[str]) -> None:
        q = len(self)
        for name, array in (("end", self.end), ("values", self.values), ("sigma", self.sigma)):
            check_shape(table, name, array, (q,))
        check_index(table, self.start, len(points), "from_point_id")
        check_index(table, self.end, len(points), "to_point_id")
        same = self.start == self.end
        if same.any():
            raise BlockError(table, "both ends are the same point", int(np.argmax(same)), "to_point_id")
        values = self.values[:, None]
        refuse(table, ~np.isfinite(values), (column,), values, "must be finite")
        if table == "distances":
            refuse(table, values <= 0.0, (column,), values, "must be > 0")
        _check_sigma(table, self.sigma[:, None], ("sigma_m",))

    def select(self, keep: Mask) -> Lines:
        rows, at = keep[self.start] & keep[self.end], np.cumsum(keep) - 1
        return Lines(at[self.start[rows]], at[self.end[rows]], self.values[rows], self.sigma[rows])


@dataclass(frozen=True, eq=False)
class Priors:
    """Prior values of additional parameters (q): camera (q) index, names (q), values and sigma (q) in the parameter's
    own unit.
    """

    camera: Indices = field(default_factory=_no_index)
    names: tuple[str, ...] = ()
    values: Floats = field(default_factory=_none)
    sigma: Floats = field(default_factory=_none)

    def __post_init__(self) -> None:
        freeze(self, camera=np.intp, values=np.float64, sigma=np.float64)

    def __len__(self) -> int:
        return len(self.camera)

    def check(self, cameras: Sequence[str]) -> None:
        q = len(self)
        check_shape("ap_priors", "names", np.array(self.names), (q,))
        check_shape("ap_priors", "values", self.values, (q,))
        check_shape("ap_priors", "sigma", self.sigma, (q,))
        check_index("ap_priors", self.camera, len(cameras), "camera_id")
        values = self.values[:, None]
        refuse("ap_priors", ~np.isfinite(values), ("value",), values, "must be finite")
        _check_sigma("ap_priors", self.sigma[:, None], ("sigma",))
        for row, name in enumerate(self.names):
            if not name or name != name.strip():
                raise BlockError("ap_priors", f"{name!r} is not the name of a parameter", row, "parameter")
        _refuse_twice("ap_priors", list(zip(self.camera.tolist(), self.names, strict=True)), "parameter")

    def select(self, keep: Mask) -> Priors:
        rows = np.flatnonzero(keep[self.camera])
        at = np.cumsum(keep) - 1
        names = tuple(self.names[i] for i in rows)
        return Priors(at[self.camera[rows]], names, self.values[rows], self.sigma[rows])


@dataclass(frozen=True, eq=False)
class Further:
    """All further observations of a block."""

    strips: Strips = field(default_factory=Strips)
    stations: Stations = field(default_factory=Stations)
    distances: Lines = field(default_factory=Lines)
    height_differences: Lines = field(default_factory=Lines)
    ap_priors: Priors = field(default_factory=Priors)

    def __bool__(self) -> bool:
        return any(len(getattr(self, name)) for name in TABLES)

    def check(self, images: Sequence[str], points: Sequence[str], cameras: Sequence[str]) -> None:
        """Raises BlockError at the first defect."""
        self.strips.check()
        self.stations.check(images, self.strips)
        self.distances.check("distances", "distance_m", points)
        self.height_differences.check("height_differences", "height_difference_m", points)
        self.ap_priors.check(cameras)

    def without(self, *tables: str) -> Further:
        """Without the named tables, all if none is named; strips go with the stations. Raises KeyError."""
        unknown = [name for name in tables if name not in TABLES]
        if unknown:
            raise KeyError(f"no further observations named {unknown[0]!r}, there are {', '.join(TABLES)}")
        gone = set(tables or TABLES)
        gone |= {"strips"} if "stations" in gone else set()
        return replace(self, **{f.name: type(getattr(self, f.name))() for f in fields(self) if f.name in gone})

    def select(self, images: Mask, points: Mask, cameras: Mask) -> Further:
        """What belongs to the images, points and cameras that are kept.

        A strip keeps its biases, but of a single station that is left no drift can be asked.
        """
        rows = np.flatnonzero(images[self.stations.image])
        strip = self.stations.strip[rows]
        used = [i for i in range(len(self.strips)) if (strip == i).any()]
        strip_at = np.full(len(self.strips) + 1, -1)
        strip_at[used] = np.arange(len(used))
        alone = {i for i in used if np.sum(strip == i) == 1}

        def kept(biases: Sequence[str]) -> tuple[str, ...]:
            return tuple("offset" if i in alone and biases[i] == "drift" else biases[i] for i in used)

        strips = Strips(tuple(self.strips.ids[i] for i in used), kept(self.strips.position), kept(self.strips.attitude))
        image_at = np.cumsum(images) - 1
        return Further(
            strips,
            self.stations.taken(rows, image_at[self.stations.image[rows]], strip_at[strip]),
            self.distances.select(points),
            self.height_differences.select(points),
            self.ap_priors.select(cameras),
        )


TABLES = ("stations", "distances", "height_differences", "ap_priors")
"""what can be left out of a block; strips belong to the stations"""


def _refuse_infinite(table: str, values: Floats, columns: Sequence[str]) -> None:
    refuse(table, np.isinf(values), columns, values, "must be finite or empty")


def _check_sigma(table: str, sigma: Floats, columns: Sequence[str], may_be_empty: bool = False) -> None:
    wrong = ~(np.isfinite(sigma) & (sigma > 0.0)) & ~(np.isnan(sigma) & may_be_empty)
    refuse(table, wrong, columns, sigma, "must be finite and > 0")
    refuse_weightless(table, sigma, columns)


def _refuse_one_without_other(values: Floats, sigma: Floats, columns: Sequence[str], sigmas: Sequence[str]) -> None:
    for alone, empty, names in ((values, sigma, sigmas), (sigma, values, columns)):
        missing = np.isfinite(alone) & np.isnan(empty)
        if missing.any():
            row, column = (int(i) for i in np.argwhere(missing)[0])
            other = sigmas[column] if names is columns else columns[column]
            raise BlockError("stations", f"is empty while {other} is given", row, names[column])


def _refuse_twice(table: str, keys: Collection[object], column: str) -> None:
    seen: dict[object, int] = {}
    for row, key in enumerate(keys):
        if seen.setdefault(key, row) != row:
            raise BlockError(table, "stands there twice", row, column)
