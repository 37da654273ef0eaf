"""Everything that the reproduction computes: both worlds flown, all tables and curves. Nothing here knows a file."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pandas as pd
from threadpoolctl import threadpool_limits

from simfield import Truth, World, build_world, presets
from simfield.block import Block, Floats
from simfield.disturbances import DistortionError
from simfield.world import CountError
from studies.comparison import (
    DecenteringFields,
    PointErrors,
    RadialCurve,
    decentering_fields,
    point_errors,
    radial_curve,
)
from studies.experiments.mauelshagen_1980 import claims, table1, table2, verdicts
from studies.experiments.mauelshagen_1980.experiment import (
    BOTH,
    CAMERAS,
    SECTIONS,
    Row,
    adjusted,
    middle_images,
    rows,
    sub_block,
)
from studies.experiments.mauelshagen_1980.trials import run_trials
from studies.experiments.reproduction import ReproductionError
from studies.session import progress_bar

WORLD = "rheidt-1980"
FILM_WORLD = "rheidt-1980-film"
"""the same with film that changes from image to image; a quarter of the trials, for comparison"""
FILM_SHARE = 4
OTHER_GEOMETRIES = 8
RADIUS_EDGES_MM = np.arange(0.0, 171.0, 10.0)


@dataclass(frozen=True, eq=False)
class MauelshagenFindings:
    """Everything that the reproduction computes; of flight 0 where no trials are named."""

    world: World
    film_world: World
    trials: int
    film_trials: int
    table1: pd.DataFrame
    table1_film: pd.DataFrame
    table2: pd.DataFrame
    table2_rms: pd.DataFrame
    geometries: pd.DataFrame
    claims: pd.DataFrame
    z0: pd.DataFrame
    errors: pd.DataFrame
    radii: dict[str, dict[str, Floats]]
    curves: dict[str, dict[str, RadialCurve]]
    """by camera and model"""
    fields: dict[str, DecenteringFields]
    block: Block
    """as a surveyor would hand it over"""
    point_errors: dict[str, PointErrors]
    """of one point a group, by model"""
    failures: list[str]


def compute(trials: int, jobs: int | None, seed: int) -> MauelshagenFindings:
    """Fly both worlds and compute everything that is reported. Flight 0 serves what needs no statistics."""
    experiment = rows()
    try:
        world, film_world = (build_world(presets[name], seed) for name in (WORLD, FILM_WORLD))
    except (CountError, DistortionError) as error:
        raise ReproductionError(str(error)) from error
    film_trials = max(2, trials // FILM_SHARE)
    with progress_bar(2 * len(experiment), "adjustments of all flights") as bar:
        flown = run_trials(world, experiment, trials, jobs, bar.update)
        film_flown = run_trials(film_world, experiment, film_trials, jobs, bar.update)
    with threadpool_limits(1):
        block, truth = world.observe(0)
        correlations = table2.table2(block, truth)
        z0 = claims.z0_correlations(block, truth)
        worlds = table2.other_worlds(world.scenario, range(seed + 1, seed + 1 + OTHER_GEOMETRIES))
        both = {model: adjusted(sub_block(block, truth, BOTH, True), model) for model in SECTIONS}
        return MauelshagenFindings(
            world=world,
            film_world=film_world,
            trials=trials,
            film_trials=film_trials,
            table1=table1.table1(experiment, flown),
            table1_film=table1.table1(experiment, film_flown),
            table2=correlations,
            table2_rms=table2.rms_of_differences(correlations),
            geometries=table2.other_geometries(worlds),
            claims=verdicts.verdicts(world, worlds, trials),
            z0=z0,
            errors=claims.standard_errors(block, truth, experiment),
            radii={c: _radii(block, truth, c) for c in CAMERAS},
            curves={c: {model: radial_curve(a, c, truth) for model, a in both.items()} for c in CAMERAS},
            fields={c: decentering_fields(both["optical"], c, truth) for c in CAMERAS},
            block=block,
            point_errors={m: point_errors(both[m], _one_a_group(block, truth)) for m in ("optical", "brown14")},
            failures=_failures(experiment, flown, WORLD) + _failures(experiment, film_flown, FILM_WORLD),
        )


def _one_a_group(block: Block, truth: Truth) -> npt.NDArray[np.bool_]:
    """(n) the central points of the groups, without control."""
    central = np.array(truth.point_ids)[truth.central]
    return np.asarray(np.isin(block.points.ids, central) & (block.points.role != "control"))


def _radii(block: Block, truth: Truth, camera: str) -> dict[str, Floats]:
    """Points of a middle image by radius, the mean over the camera's middle images, with and without auxiliary."""
    images = [block.images.ids.index(name) for name in middle_images(truth, camera)]
    main = np.isin(block.points.ids, truth.main_points)
    observations = block.observations
    own = np.isin(observations.image, images)
    counts = {}
    for label, used in {"with auxiliary points": own, "without": own & main[observations.point]}.items():
        histogram, _ = np.histogram(np.hypot(*observations.xy[used].T), RADIUS_EDGES_MM)
        counts[label] = histogram / len(images)
    return counts


def _failures(experiment: list[Row], flown: pd.DataFrame, world: str) -> list[str]:
    return [f"{world}: {line}" for line in table1.failures(experiment, flown)]
