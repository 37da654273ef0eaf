from .distortion import (
    DistortionError as DistortionError,
    measured_from_ideal as measured_from_ideal,
    systematic as systematic,
)
from .draws import ImageNoise as ImageNoise, ImagePointDraws as ImagePointDraws
from .effects import (
    EFFECTS as EFFECTS,
    Decentering as Decentering,
    EarthCurvature as EarthCurvature,
    Effect as Effect,
    EffectOn as EffectOn,
    FilmAffine as FilmAffine,
    FilmPolynomial as FilmPolynomial,
    RadialPolynomial as RadialPolynomial,
    RadialTable as RadialTable,
    Refraction as Refraction,
    UnflatFilm as UnflatFilm,
    along_radius as along_radius,
)
from .expansion import REACH_MM as REACH_MM, second_order as second_order
from .film import (
    DEGREES as DEGREES,
    REFERENCE_MM as REFERENCE_MM,
    TERMS as TERMS,
    DrawnFilm as DrawnFilm,
    FilmTable as FilmTable,
    FilmVariation as FilmVariation,
    draw_film as draw_film,
    film_monomials as film_monomials,
)
from .film_compiled import (
    COLUMNS as COLUMNS,
    add_film as add_film,
    film_coefficients as film_coefficients,
    solve_film as solve_film,
)
from .kinds import OneOf as OneOf, by_kind as by_kind
from .moving_film import MovingFilm as MovingFilm, refuse_steep as refuse_steep
from .noise import Noise as Noise, geodetic_noise as geodetic_noise, image_noise as image_noise
from .visibility import shown as shown
