"""What a set of additional parameters (AP) is: a declaration of terms.

Convention: measured + v = projected + d(measured). d is the distortion contained in the measurement, evaluated at the
measured image coordinates x (flight direction) and y in mm. Nearly every set is linear in its parameters, so that the
matrix of its terms (its basis) is also its Jacobian; one that is not says so and gives d and its derivatives itself.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from numbers import Real
from typing import Any, ClassVar

import numpy as np

from adjust.ap_models.terms import Term, numbered
from simfield.block import Floats


class Certainty(StrEnum):
    """How sure the formula of a set is.

    CERTAIN: confirmed by a second source or by a computed property. READING: the best reading of a bad scan.
    RECONSTRUCTION: parts of the printed form could not be read and are guessed. MEMORY: from general knowledge, with no
    page of the source at hand.
    """

    CERTAIN = "certain"
    READING = "reading"
    RECONSTRUCTION = "reconstruction"
    MEMORY = "memory"


@dataclass(frozen=True)
class ApModel:
    """A set of additional parameters, declared by its terms.

    A subclass is a frozen dataclass. Its fields are the settings, with the unit in the name and
    metadata={"about": ...}; its class variables say what it is and where it comes from; `terms` lists one (dx, dy) for
    each parameter, as literally as the source prints it. `parameters` names them. A set of the user's own needs no more
    than `terms`. Raises ValueError, naming it, for a setting with an impossible value.
    """

    id: ClassVar[str] = "own"
    title: ClassVar[str] = "A set of the user's own"
    author: ClassVar[str] = "-"
    year: ClassVar[int] = 0
    """of the set, or of the page that gives it where the year of the set itself is not known"""
    source: ClassVar[str] = "the user's own file"
    certainty: ClassVar[Certainty] = Certainty.CERTAIN
    formula: ClassVar[str] = ""
    """the terms in plain text, as `simfield models ID` prints them"""

    @property
    def parameters(self) -> tuple[str, ...]:
        """The names of the parameters, in the order of the terms; a1, a2, ... unless a set says otherwise."""
        return numbered("a", len(self.terms(np.zeros(1), np.zeros(1))))

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        """The terms at x, y (k), mm: one (dx, dy) a parameter, in mm per unit of the parameter."""
        raise NotImplementedError

    @property
    def linear(self) -> bool:
        """Whether d is linear in the parameters, so that `basis` is all there is to know."""
        return True

    @property
    def principal_distance(self) -> str:
        """The parameter that is added to the principal distance in the projection, if there is one; no part of d."""
        return ""

    def evaluate(self, x: Floats, y: Floats, values: Floats) -> tuple[Floats, Floats]:
        """d (k, 2) at parameters `values` (a), and its derivatives by them (k, 2, a); for sets that are not linear.

        x, y (k), mm, are then reckoned from the principal point that the block gives, not from the fiducial centre.
        """
        basis = self.basis(x, y)
        return basis @ values, basis

    @property
    def why_not_estimable(self) -> Mapping[str, str]:
        """The parameters that a flat near-vertical block cannot tell from its exterior orientation, and why.

        An adjustment looks whether its own geometry can tell them, and refuses by name those that it cannot
        (adjust.solution.determinability).
        """
        return {}

    @property
    def not_estimable(self) -> tuple[str, ...]:
        """The names of the parameters in `why_not_estimable`."""
        return tuple(self.why_not_estimable)

    @property
    def orthogonal_on_mm(self) -> tuple[float, ...]:
        """The x (and y) of the grid on which the set claims to be orthogonal, also to the orientation; or none."""
        return ()

    def basis(self, x_mm: Floats, y_mm: Floats) -> Floats:
        """All terms as one array (k, 2, a) at image coordinates x_mm, y_mm (k): mm per unit of the parameter."""
        x, y = np.broadcast_arrays(np.asarray(x_mm, float), np.asarray(y_mm, float))
        basis = np.zeros((x.size, 2, len(self.parameters)))
        for j, (dx, dy) in enumerate(self.terms(x.ravel(), y.ravel())):
            basis[:, 0, j] = dx
            basis[:, 1, j] = dy
        return basis

    @property
    def settings(self) -> dict[str, Any]:
        """The settings by name, as given."""
        return {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}

    def __post_init__(self) -> None:
        for f in dataclasses.fields(self):
            value = getattr(self, f.name)
            if complaint := _complaint(value, f):
                raise ValueError(f"{self.id}: {f.name} = {value} is not allowed, it must be {complaint}")


def _complaint(value: Any, setting: dataclasses.Field[Any]) -> str:
    """What the value of a setting must be and is not; empty if it is all right."""
    truth = isinstance(value, bool | np.bool_)
    if "names" in setting.metadata:
        known = setting.metadata["names"]
        some = isinstance(value, tuple) and len(set(value)) == len(value) < len(known) and set(value) <= set(known)
        return "" if some else f"some of {', '.join(known)}, each once"
    if isinstance(setting.default, bool):
        return "" if truth else "True or False"
    if "range" in setting.metadata:
        low, high = setting.metadata["range"]
        whole = isinstance(value, int | np.integer) and not truth
        return "" if whole and low <= value <= high else f"a whole number from {low} to {high}"
    if isinstance(setting.default, float) and (truth or not isinstance(value, Real)):
        return "a number"
    if isinstance(value, Real) and not np.isfinite(float(value)):
        return "finite"
    if "above" in setting.metadata and value <= setting.metadata["above"]:
        return f"greater than {setting.metadata['above']:g}"
    if "at_least" in setting.metadata and value < setting.metadata["at_least"]:
        return f"at least {setting.metadata['at_least']:g}"
    return ""
