from .block_of_trials import Draw as Draw, compute as compute
from .drawn_trials import image_points as image_points
from .geometry import Geometry as Geometry, forget as forget
from .measured_trials import MeasuredTrials as MeasuredTrials
