"""What is unknown in a block: exterior orientations, additional parameters, point coordinates.

The working vector x holds, in this order, 6 elements for every image, the additional parameters of every set, and 3
coordinates for every point. The first two kinds are the orientation unknowns (their number is `orientation`); the
points behind them are eliminated. Coordinates held fixed stay in x and are marked in `free`, so indices never shift.
Object coordinates are reduced to `origin`, which keeps digits in large national coordinates.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from adjust.ap_models import ApModel
from adjust.model.rotation import Flags, angles_of, rotation_matrices, steep
from simfield.block import Block, Floats, Indices

EXTERIOR_NAMES = ("X0", "Y0", "Z0", "omega", "phi", "kappa")
POINT_NAMES = ("X", "Y", "Z")


@dataclass(frozen=True, eq=False)
class ApSet:
    """One set of additional parameters: its id (that of its camera, or as ap_by says), its model and its place in x."""

    id: str
    model: ApModel
    columns: slice


@dataclass(frozen=True, eq=False)
class Unknowns:
    """The layout of the working vector x of a block."""

    block: Block
    sets: tuple[ApSet, ...]
    image_set: Indices
    """(m) the AP set of every image"""
    free: npt.NDArray[np.bool_]
    """(size) False for coordinates held fixed"""
    origin: Floats
    """(3) the reduction of object coordinates, m"""
    further: tuple[tuple[str, str], ...] = ()
    """owner and name of the unknowns that further observations bring along; they stand behind the last AP set"""
    coupled: Indices = field(default_factory=lambda: np.empty(0, dtype=np.intp))
    """(q) coordinates, counted three a point, that further observations tie to those of other points: they are not
    eliminated, but stand behind the further unknowns; their old places in x stay empty and are not free"""
    renamed: Flags | None = None
    """(m) the images whose angles in x are by renamed object axes (adjust.model.rotation); None: none is"""

    @classmethod
    def of(
        cls,
        block: Block,
        model: ApModel | Mapping[str, ApModel],
        ap_by: Mapping[str, str] | None = None,
        further: tuple[tuple[str, str], ...] = (),
        coupled: Sequence[str] = (),
    ) -> Unknowns:
        """ap_by: the id of the AP set of every image id; None: one set a camera. coupled: ids of points.

        Raises KeyError when `model` is a mapping that lacks a camera of the block or ap_by one that lacks an image,
        and ValueError when ap_by lets images of two cameras share a set.
        """
        set_ids, image_set = _sets_of_images(block, ap_by)
        start = 6 * len(block.images)
        sets = []
        for number, set_id in enumerate(set_ids):
            camera_id = block.cameras[block.images.camera[np.argmax(image_set == number)]].camera_id
            if isinstance(model, Mapping) and camera_id not in model:
                raise KeyError(f"no AP model given for camera {camera_id!r}; given are {', '.join(model) or 'none'}")
            chosen = model[camera_id] if isinstance(model, Mapping) else model
            count = len(chosen.parameters)
            sets.append(ApSet(set_id, chosen, slice(start, start + count)))
            start += count
        tied = np.isin(block.points.ids, list(coupled))[:, None] & ~block.points.fixed
        start += len(further) + int(tied.sum())
        free = np.ones(start + 3 * len(block.points), dtype=bool)
        free[start:] = ~(block.points.fixed | tied).ravel()
        return cls(block, tuple(sets), image_set, free, _origin(block), further, np.flatnonzero(tied))

    @property
    def orientation(self) -> int:
        """The number of orientation unknowns, and the place of the first coordinate in x."""
        parameters = sum(len(s.model.parameters) for s in self.sets)
        return 6 * len(self.block.images) + parameters + len(self.further) + len(self.coupled)

    @cached_property
    def places(self) -> Indices:
        """(3 n) the place in x of every coordinate."""
        places = self.orientation + np.arange(3 * len(self.block.points))
        places[self.coupled] = self.orientation - len(self.coupled) + np.arange(len(self.coupled))
        return places

    @cached_property
    def held(self) -> npt.NDArray[np.bool_]:
        """(n, 3): coordinates that are not eliminated, because they are fixed or coupled."""
        held = self.block.points.fixed.copy()
        held.ravel()[self.coupled] = True
        return held

    @property
    def count(self) -> int:
        """The number of unknowns, fixed coordinates not counted."""
        return int(self.free.sum())

    def exterior(self, x: Floats) -> Floats:
        """(m, 6) view of x, X0 reduced."""
        return x[: 6 * len(self.block.images)].reshape(-1, 6)

    def with_renamed(self, x: Floats) -> tuple[Unknowns, Floats]:
        """The layout for images that look along the object's X axis in x, if there are, and x in it."""
        told = self.told(x)
        renamed = steep(self.exterior(told)[:, 3:])
        if not renamed.any():
            return replace(self, renamed=None), told
        own = told.copy()
        angles = self.exterior(own)[:, 3:]
        angles[renamed] = angles_of(rotation_matrices(angles[renamed]), renamed[renamed])
        return replace(self, renamed=renamed), own

    def told(self, x: Floats) -> Floats:
        """x (..., size) with the angles of people; x itself where no axis is renamed."""
        if self.renamed is None:
            return x
        told = np.array(x)
        exterior = told[..., : 6 * len(self.block.images)].reshape(*x.shape[:-1], -1, 6)
        for image in np.flatnonzero(self.renamed):
            own = exterior[..., image, 3:].reshape(-1, 3)
            flags = np.ones(len(own), dtype=bool)
            exterior[..., image, 3:] = angles_of(rotation_matrices(own, flags)).reshape(*x.shape[:-1], 3)
        told[..., : 6 * len(self.block.images)] = exterior.reshape(*x.shape[:-1], -1)
        return told

    def points(self, x: Floats) -> Floats:
        """(n, 3) view of x, reduced; a copy where coordinates are coupled."""
        if len(self.coupled):
            return np.asarray(x[self.places].reshape(-1, 3))
        return x[self.orientation :].reshape(-1, 3)

    @property
    def _further_start(self) -> int:
        return self.orientation - len(self.coupled) - len(self.further)

    def name(self, index: int) -> str:
        """The name of unknown `index`, such as "Z0 of image sww-1"."""
        images = 6 * len(self.block.images)
        if index < images:
            return f"{EXTERIOR_NAMES[index % 6]} of image {self.block.images.ids[index // 6]}"
        if index >= self.orientation:
            at = index - self.orientation
            return f"{POINT_NAMES[at % 3]} of point {self.block.points.ids[at // 3]}"
        for s in self.sets:
            if s.columns.start <= index < s.columns.stop:
                return f"{s.model.parameters[index - s.columns.start]} of {self.owner_of(s)}"
        if index >= self.orientation - len(self.coupled):
            at = int(self.coupled[index - self.orientation])
            return f"{POINT_NAMES[at % 3]} of point {self.block.points.ids[at // 3]}"
        if index >= self._further_start:
            owner, name = self.further[index - self._further_start]
            return f"{name} of {owner}"
        raise IndexError(index)

    def owner_of(self, ap: ApSet) -> str:
        """Whose set it is, in words: that of a camera, or of some of its images under a name of their own."""
        if ap.id in self.block.camera_ids:
            return f"camera {ap.id}"
        return f"image {ap.id}" if ap.id in self.block.images.ids else f"the set {ap.id}"

    def index(self, owner: str, name: str) -> int:
        """The place in x of unknown `name` of the image, camera or point `owner`. Raises KeyError if there is none."""
        if name in EXTERIOR_NAMES and owner in self.block.images.ids:
            return 6 * self.block.images.ids.index(owner) + EXTERIOR_NAMES.index(name)
        if name in POINT_NAMES and owner in self.block.points.ids:
            return int(self.places[3 * self.block.points.ids.index(owner) + POINT_NAMES.index(name)])
        for s in self.sets:
            if s.id == owner and name in s.model.parameters:
                return int(s.columns.start + s.model.parameters.index(name))
        if (owner, name) in self.further:
            return self._further_start + self.further.index((owner, name))
        raise KeyError(f"no unknown {name!r} of {owner!r} in this adjustment")


def _sets_of_images(block: Block, ap_by: Mapping[str, str] | None) -> tuple[list[str], Indices]:
    """The ids of the sets, in the order of cameras and images, and the set (m) of every image."""
    camera_ids = [block.cameras[c].camera_id for c in block.images.camera]
    if ap_by is None:
        used = [c.camera_id for c in block.cameras if c.camera_id in camera_ids]
        return used, np.array([used.index(c) for c in camera_ids], dtype=np.intp)
    named = [ap_by[image_id] for image_id in block.images.ids]
    camera_of: dict[str, str] = {}
    for set_id, camera_id in zip(named, camera_ids, strict=True):
        if camera_of.setdefault(set_id, camera_id) != camera_id:
            raise ValueError(f"AP set {set_id!r} has images of the cameras {camera_of[set_id]!r} and {camera_id!r}")
    set_ids = list(camera_of)
    return set_ids, np.array([set_ids.index(name) for name in named], dtype=np.intp)


def _origin(block: Block) -> Floats:
    """The rounded median of what is known, check points apart: they must not touch the result, not even by rounding.

    What is given of other points may be a placeholder, so it counts only where there is no control.
    """
    is_control = block.points.role == "control"
    has_control = np.isfinite(block.points.coordinates[is_control]).any()
    used = is_control if has_control else block.points.role != "check"
    known = np.vstack([block.points.coordinates[used], block.images.exterior[:, :3] * [1.0, 1.0, np.nan]])
    origin = np.zeros(3)
    for axis in range(3):
        column = known[:, axis][np.isfinite(known[:, axis])]
        if column.size:
            origin[axis] = np.round(np.median(column))
    return origin
