"""Variance components of the twin: what may have disturbed the images and coordinates of 1969, each of one unit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from simfield import World
from simfield.block import Floats, Indices
from simfield.disturbances import (
    DEGREES,
    REFERENCE_MM,
    TERMS,
    FilmAffine,
    FilmPolynomial,
    FilmVariation,
    Noise,
    film_monomials,
)
from simfield.scenario import Scenario
from studies.experiments.mauelshagen_1980 import CAMERAS

Per = Literal["camera", "flight", "image"]
DEFORMATIONS = ("affine", "quadratic", "cubic")
LEVELS: tuple[Per, ...] = ("camera", "flight", "image")


@dataclass(frozen=True)
class Component:
    """One source of error with one variance: noise or film deformation of a camera, or the geodetic survey.

    Its size is a standard deviation: um in the image (film: of one term at 100 mm), mm for the survey.
    """

    kind: Literal["noise", "film", "geodetic"]
    camera: str = ""
    terms: str = ""
    per: Per = "image"

    def __str__(self) -> str:
        if self.kind == "film":
            return f"{self.camera} film, {self.terms}, one a {self.per}"
        return f"{self.camera} image noise" if self.kind == "noise" else "geodetic error"

    @property
    def unit(self) -> str:
        return "mm" if self.kind == "geodetic" else "um at 100 mm" if self.kind == "film" else "um"


def all_components() -> tuple[Component, ...]:
    """Everything that the twin may be made of."""
    noise = [Component("noise", camera) for camera in CAMERAS]
    affinity = [Component("film", camera, "affinity", "camera") for camera in CAMERAS]
    film = [Component("film", camera, terms, per) for camera in CAMERAS for terms in DEFORMATIONS for per in LEVELS]
    return (*noise, *affinity, *film, Component("geodetic"))


def owners(world: World, per: Per) -> tuple[str, ...]:
    """(m) whose deformation every image has."""
    plan = world.plan
    return {"image": plan.image_ids, "flight": plan.flight_ids, "camera": plan.camera_ids}[per]


def film_fields(world: World, component: Component) -> Floats:
    """(2k, q): the displacement, mm, of every image coordinate for each coefficient of 1 um at 100 mm, one a column."""
    rows = _rows_by_owner(world, component)
    columns = TERMS[component.terms]
    monomials = film_monomials(world.distorted)[:, columns]
    scale = 1e-3 / REFERENCE_MM ** DEGREES[columns[0]]
    axes = (1,) if component.terms == "affinity" else (0, 1)
    fields = np.zeros((len(world.distorted), 2, len(rows), len(axes), len(columns)))
    for number, own in enumerate(rows):
        for place, axis in enumerate(axes):
            fields[own, axis, number, place] = scale * monomials[own]
    return fields.reshape(2 * len(world.distorted), -1)


def _rows_by_owner(world: World, component: Component) -> list[Indices]:
    """The image points that share a draw of the component."""
    named = np.array(owners(world, component.per))
    own = np.array(world.plan.camera_ids) == component.camera
    return [np.flatnonzero((own & (named == name))[world.image]) for name in dict.fromkeys(named[own].tolist())]


def scenario_with(base: Scenario, name: str, sizes: Sequence[tuple[Component, float]]) -> Scenario:
    """The scenario with these components in place of its own noise and film, constant film included; lenses stay."""
    noise = {c.camera: size for c, size in sizes if c.kind == "noise"}
    survey = next((size for c, size in sizes if c.kind == "geodetic"), 0.0)
    terms: Any
    film = []
    for component, size in sizes:
        if component.kind == "film" and size > 0.0:
            terms = component.terms
            film.append(FilmVariation(component.camera, terms, size, component.per))
    effects = tuple(on for on in base.effects if not isinstance(on.effect, (FilmAffine, FilmPolynomial)))
    errors = Noise(image_um=noise, assumed_um=base.noise.assumed_um, geodetic_mm=survey)
    return replace(base, name=name, effects=effects, film=tuple(film), noise=errors)
