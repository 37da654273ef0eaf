"""Worlds that many tests look at; they are read-only, so one of each serves a whole session."""

from __future__ import annotations

import pytest

from tests import synthetic


@pytest.fixture(scope="session")
def ww_world() -> synthetic.World:
    """One wide-angle camera, four strips in four headings, 12 images, 41 points, 40 m relief, noise-free."""
    return synthetic.world([(synthetic.WW, synthetic.fly(synthetic.WW, 10500.0))], synthetic.quincunx())


@pytest.fixture(scope="session")
def vertical_world() -> synthetic.World:
    """The same flight without any tilt over a field without relief: the classic case of what cannot be separated."""
    flight = synthetic.fly(synthetic.WW, 10500.0, tilt_rad=0.0)
    return synthetic.world([(synthetic.WW, flight)], synthetic.quincunx(relief_m=0.0))


@pytest.fixture(scope="session")
def two_camera_world() -> synthetic.World:
    """A wide-angle and a super-wide-angle camera, 24 images in four headings, 41 groups of two points, noise-free."""
    flights = [
        (synthetic.WW, synthetic.fly(synthetic.WW, 10500.0)),
        (synthetic.SWW, synthetic.fly(synthetic.SWW, 9600.0, seed=4)),
    ]
    return synthetic.world(flights, synthetic.quincunx(per_group=2))
