from .collinearity import linearise as linearise, project as project
from .rotation import (
    Flags as Flags,
    angles_by_angles as angles_by_angles,
    angles_of as angles_of,
    rotation_matrices as rotation_matrices,
    steep as steep,
)
from .set_owners import CHOICES as CHOICES, ApBy as ApBy, ap_sets as ap_sets
from .similarity import Similarity as Similarity, point_motions as point_motions, station_motions as station_motions
from .unknowns import EXTERIOR_NAMES as EXTERIOR_NAMES, POINT_NAMES as POINT_NAMES, ApSet as ApSet, Unknowns as Unknowns
