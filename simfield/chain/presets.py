"""Chains that ship, by name."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from simfield.chain.air import Air
from simfield.chain.film import RandomField
from simfield.chain.lens import Lens, RadialCertificate
from simfield.chain.machine import Comparator, Errors, Marks
from simfield.chain.measure import Chain
from simfield.effects import Decentering

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
