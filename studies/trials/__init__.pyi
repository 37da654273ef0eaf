from .block_of_trials import Draw as Draw, compute as compute
from .drawn_trials import DrawnTrials as DrawnTrials, image_points as image_points, put as put, repeated as repeated
from .geometry import Geometry as Geometry, Prepared as Prepared, forget as forget
from .measured_trials import MeasuredTrials as MeasuredTrials
from .trial_columns import (
    CONSTANTS as CONSTANTS,
    CONVERGED as CONVERGED,
    CRASHED as CRASHED,
    DEVIATIONS as DEVIATIONS,
    SENTENCES as SENTENCES,
)
