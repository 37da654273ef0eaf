"""The flights of Ziemann & El-Hakim 1982: two wide-angle reseau cameras, flown together over Rheidt and Jamijarvi.

Each camera takes a block of 3 x 3 images with 60 % overlap in both directions at about 1:5000, and four images at about
1:10 000 in four headings that cover the area of the block. All points of the field are control, held fixed.

Everything about lenses, film and noise is assumed; the sources are silent. What is FITTED, and to which published
figures: the amplitude of each camera's lens in each field to "none" (RC8R at Rheidt 8.3 um, Jamijarvi 5.2; RMK-AR 7.6
and 6.0); the image noise of each camera in each field to the best set, n; the film to the fall of "none" and of n
from level to level of the reseau correction. The shapes of the lenses are FITTED too, to the order of the sets: for
the RC8R the ratios of the powers of the radius, of the decentering and of one cubic film term (by linear computation,
so that n, then c, l and m, then b and f, then k are best at Rheidt), for the RMK-AR mostly decentering, because the
purely radial sets c and k do badly there. So the orders that come out are no evidence for this world; that one lens
with a handful of terms can bring them about is all that they show.

That one lens would need two amplitudes in two fields is a contradiction of this world, not of the papers: the published
differences between "none" and n are twice as large at Rheidt (5.9 um) as at Jamijarvi (2.9 um), and why is not known.
"""

from __future__ import annotations

from dataclasses import replace

from simfield.disturbances import (
    Decentering,
    EffectOn,
    FilmAffine,
    FilmPolynomial,
    FilmVariation,
    Noise,
    RadialPolynomial,
)
from simfield.scenario.scenario import Scenario
from simfield.world import RC8R, RMK_AR, Control, Flight, Quincunx, RegularGrid, Relief

HIGH_HEADINGS_GON = (0.0, 100.0, 200.0, 300.0)


def _flights(camera_id: str) -> tuple[Flight, Flight]:
    block = Flight(f"{camera_id}-block", camera_id, 5000.0, strips=3, forward_overlap=0.6, sidelap=0.6)
    return block, Flight(f"{camera_id}-high", camera_id, 10000.0, HIGH_HEADINGS_GON, images_per_strip=1)


def _lenses(rc8r: float, rmk_ar: float) -> tuple[EffectOn, ...]:
    """Both lenses and the film deformation that all images of a camera share; the lenses times their amplitudes."""
    return (
        EffectOn(RadialPolynomial(rc8r * -1.65e-8, rc8r * 1.4e-13, rc8r * 6.5e-18, r0_mm=100.0), camera="rc8r"),
        EffectOn(Decentering(p1=rc8r * -6.7e-7), camera="rc8r"),
        EffectOn(RadialPolynomial(rmk_ar * -0.6e-8, rmk_ar * 2.0e-13, r0_mm=100.0), camera="rmk-ar"),
        EffectOn(Decentering(rmk_ar * -3.0e-7, rmk_ar * 5.7e-7), camera="rmk-ar"),
        EffectOn(FilmAffine(d=1.4e-5), camera="rc8r"),
        EffectOn(FilmPolynomial(dx_y3=1.3e-9), camera="rc8r"),
        EffectOn(FilmAffine(d=5.5e-5), camera="rmk-ar"),
    )


FILM = (
    FilmVariation("rc8r", "affine", 1.2),
    FilmVariation("rmk-ar", "affine", 2.1),
    FilmVariation("rc8r", "bilinear", 4.3),
    FilmVariation("rmk-ar", "bilinear", 4.3),
)

RHEIDT_1982 = Scenario(
    name="ziemann-rheidt",
    field=Quincunx(),
    control=Control("dense"),
    cameras=(RC8R, RMK_AR),
    flights=(*_flights("rc8r"), *_flights("rmk-ar")),
    effects=_lenses(0.99, 1.05),
    film=FILM,
    noise=Noise(image_um={"rc8r": 3.5, "rmk-ar": 4.3}, assumed_um=5.0, geodetic_mm=9.0),
)

# About 317 points on 2 km x 2 km (National Board of Survey, Finland): here 18 x 18 at equal distances, 324. Geodetic
# errors of 4 mm: their published bound in plan is 4.2 mm. Relief: assumption.
JAMIJARVI_1982 = replace(
    RHEIDT_1982,
    name="ziemann-jamijarvi",
    field=RegularGrid(18, 18, 2000.0 / 17.0, relief=Relief(mean_m=120.0, sigma_m=3.0)),
    flights=tuple(replace(f, ground_height_m=120.0) for f in RHEIDT_1982.flights),
    effects=_lenses(0.56, 0.86),
    noise=Noise(image_um={"rc8r": 2.2, "rmk-ar": 3.35}, assumed_um=5.0, geodetic_mm=4.0),
)
