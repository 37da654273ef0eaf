"""Chains that ship, by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType

from simfield.chain.air import Air
from simfield.chain.comparator import Comparator, Errors, Marks
from simfield.chain.lens import Lens, RadialCertificate
from simfield.chain.measure import Chain
from simfield.chain.random_field import RandomField
from simfield.disturbances import Decentering

# Half-diagonals of invented curves inside the makers' bounds (Pleogon A 5 um, S-Pleogon A 7 um); certificates of the
# time give such four curves, but none of these cameras' is at hand. Camera tilt by a window or mount: assumption.
RADII = (0.0, 20.0, 40.0, 60.0, 80.0, 100.0, 120.0, 140.0, 165.0)
WW_CERTIFICATE = RadialCertificate(
    RADII,
    (
        (0.0, 2.0, 3.5, 4.0, 2.5, 0.5, -2.0, -3.5, 0.0),
        (0.0, 1.5, 3.0, 3.0, 2.0, -0.5, -3.0, -4.5, -1.0),
        (0.0, 2.5, 4.0, 4.5, 3.0, 0.5, -1.5, -3.0, 0.5),
        (0.0, 2.0, 3.0, 3.5, 2.0, -0.5, -2.5, -4.0, -0.5),
    ),
)
SWW_CERTIFICATE = RadialCertificate(
    RADII,
    (
        (0.0, 3.0, 5.0, 5.5, 4.0, 1.0, -3.0, -5.5, 0.0),
        (0.0, 2.5, 4.5, 5.0, 3.0, 0.0, -4.0, -6.0, -1.0),
        (0.0, 3.0, 5.5, 6.0, 4.5, 1.0, -2.5, -5.0, 0.5),
        (0.0, 2.0, 4.0, 4.5, 2.5, -1.0, -4.5, -6.5, -1.5),
    ),
)
PSK_1969 = Chain(
    name="psk-1969",
    air=Air(refraction=True, curvature=True),
    lenses=(
        Lens("ww", WW_CERTIFICATE, Decentering(1e-7, -1e-7), tilt_deg=(0.004, -0.003), source="assumption"),
        Lens("sww", SWW_CERTIFICATE, Decentering(-1e-7, 1e-7), tilt_deg=(-0.003, 0.002), source="assumption"),
    ),
    film_field=RandomField(sigma_um=2.0, length_mm=40.0),
    marks=Marks("mid-side", calibration_um=1.0),
    comparator=Comparator((40.0, -25.0), 15.0, (1.5, -1.0), 0.5, 5.0, setting_um=2.0),
    errors=Errors(pointing_um=2.0),
)

chains: Mapping[str, Chain] = MappingProxyType({chain.name: chain for chain in (Chain(), PSK_1969)})
"""The chains by their name."""


def without(chain: Chain, *stages: str) -> Chain:
    """The chain without some of the STAGES. Raises ValueError for a stage that there is not."""
    for stage in stages:
        if stage not in STAGES:
            raise ValueError(f"no stage {stage!r}, stages are {', '.join(STAGES)}")
        chain = STAGES[stage](chain)
    return chain


STAGES: Mapping[str, Callable[[Chain], Chain]] = MappingProxyType(
    {
        "refraction": lambda c: replace(c, air=replace(c.air, refraction=False)),
        "curvature": lambda c: replace(c, air=replace(c.air, curvature=False)),
        "lens": lambda c: replace(c, lenses=()),
        "film-field": lambda c: replace(c, film_field=None),
        "marks": lambda c: replace(c, marks=replace(c.marks, calibration_um=0.0)),
        "comparator": lambda c: replace(
            c, comparator=Comparator(setting_um=c.comparator.setting_um, settings=c.comparator.settings)
        ),
        "settings": lambda c: replace(c, comparator=replace(c.comparator, setting_um=0.0)),
        "errors": lambda c: replace(c, errors=Errors()),
    }
)
"""How each stage is switched off, by its name."""
