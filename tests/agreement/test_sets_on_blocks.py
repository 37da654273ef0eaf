"""Every set on the blocks of 1980 and of 1982, each camera alone and both together: adjusted, and what is hardly
determined is named.

pytest turns every warning into an error, so none is given.
"""

from __future__ import annotations

import numpy as np
import pytest

from adjust import ApModel, Status, adjust_block, ap_models
from adjust.ap_models.lookup import MODELS
from simfield import presets, simulate
from simfield.block.block import Block

HARDLY = {"rheidt-1980": {"brown1971": "dc", "brown1976": "a21"}, "ziemann-rheidt": {}, "ziemann-jamijarvi": {}}
"""by block and set, the parameter that the block hardly determines: on the blocks of 1982 all points are control held
fixed, which makes tilts of a degree enough for a principal distance good to some hundredths of a millimetre"""
PARTS = ("first camera", "second camera", "both cameras")


@pytest.fixture(scope="module", params=sorted(HARDLY))
def whole(request: pytest.FixtureRequest) -> tuple[str, Block]:
    return request.param, simulate(presets[request.param], 1980)[0]


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("model", [pytest.param(kind(), id=kind.id) for kind in MODELS])
def test_a_set_is_adjusted_and_says_what_is_weak(whole: tuple[str, Block], part: str, model: ApModel) -> None:
    name, block = whole
    cameras = block.camera_ids if part == "both cameras" else [block.camera_ids[PARTS.index(part)]]
    a = adjust_block(block.select(cameras=cameras), model)
    parameter = HARDLY[name].get(model.id)
    assert a.status is Status.CONVERGED, a.message
    for camera in cameras:
        assert np.isfinite(a.ap[camera].std).all()
        assert (a.ap[camera].std > 0.0).all()
    if parameter is None:
        assert a.message == "converged"
        return
    for camera in cameras:
        assert f"{parameter} of camera {camera} is hardly determined" in a.message
    assert f'leave out without=("{parameter}",)' in a.message
    rest = adjust_block(block.select(cameras=cameras), ap_models.get(model.id, without=(parameter,)))
    assert rest.status is Status.CONVERGED, rest.message
