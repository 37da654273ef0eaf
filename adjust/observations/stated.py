"""The further observations that a block states, as groups of an adjustment."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from adjust.ap_models import ApModel
from adjust.observations.ap_priors import ApPriors
from adjust.observations.ground import Distances, HeightDifferences
from adjust.observations.group import Group
from adjust.observations.stations import StationAttitudes, StationPositions
from simfield.block import Block, Floats


def stated_groups(block: Block, model: ApModel | Mapping[str, ApModel]) -> tuple[Group, ...]:
    """The groups of a block, none where it states nothing beside image points and control.

    Raises ValueError for the prior of a parameter that the model of its camera does not have.
    """
    return (*_stations(block), *_ground(block), *_priors(block, model))


def _stations(block: Block) -> list[Group]:
    stations, strips = block.further.stations, block.further.strips
    groups: list[Group] = []
    both = (
        (StationPositions, stations.position, stations.sigma_position, strips.position),
        (StationAttitudes, stations.attitude, stations.sigma_attitude, strips.attitude),
    )
    for kind, values, sigma, bias in both:
        rows = np.flatnonzero(np.isfinite(values).any(axis=1))
        if not len(rows):
            continue
        said = dict(zip(strips.ids, bias, strict=True))
        groups.append(
            kind(
                tuple(block.images.ids[i] for i in stations.image[rows]),
                values[rows],
                sigma[rows],
                tuple("" if i < 0 else strips.ids[i] for i in stations.strip[rows]),
                offset=frozenset(name for name, b in said.items() if b in ("offset", "drift")),
                drift=frozenset(name for name, b in said.items() if b == "drift"),
                time=_times(block)[rows],
            )
        )
    return groups


def _times(block: Block) -> Floats:
    """(q) from -1 to 1 along every strip, by the clock, or where there is none by the order of its stations."""
    stations = block.further.stations
    times = np.zeros(len(stations))
    for strip in range(len(block.further.strips)):
        rows = np.flatnonzero(stations.strip == strip)
        clock = stations.time_s[rows]
        clock = clock if np.isfinite(clock).all() else np.arange(float(len(rows)))
        half = 0.5 * np.ptp(clock)
        times[rows] = (clock - clock.min()) / half - 1.0 if half > 0.0 else 0.0
    return times


def _ground(block: Block) -> list[Group]:
    ids, groups = block.points.ids, []
    for kind, lines in ((Distances, block.further.distances), (HeightDifferences, block.further.height_differences)):
        if len(lines):
            ends = tuple((ids[a], ids[b]) for a, b in zip(lines.start, lines.end, strict=True))
            groups.append(kind(ends, lines.values, lines.sigma))
    return list(groups)


def _priors(block: Block, model: ApModel | Mapping[str, ApModel]) -> list[Group]:
    priors, groups = block.further.ap_priors, []
    for number, camera_id in enumerate(block.camera_ids):
        rows = np.flatnonzero(priors.camera == number)
        values = {priors.names[i]: (float(priors.values[i]), float(priors.sigma[i])) for i in rows}
        chosen = model.get(camera_id) if isinstance(model, Mapping) else model
        for name in values:
            if chosen is not None and name not in chosen.parameters:
                has = f"it has {', '.join(chosen.parameters)}" if chosen.parameters else "it has none"
                raise ValueError(
                    f"ap_priors: the set {chosen.id} of camera {camera_id} has no parameter {name!r}, {has}; take the "
                    "set that the priors are of, or leave them out"
                )
        if values:
            groups.append(ApPriors(camera_id, values))
    return list(groups)
