from . import group as group
from .ap_priors import ApPriors as ApPriors
from .ground import Distances as Distances, HeightDifferences as HeightDifferences
from .group import Group as Group, TwoImagesError as TwoImagesError, unknowns_of as unknowns_of
from .image_points import ImagePoints as ImagePoints
from .observations import Observations as Observations
from .stated import stated_groups as stated_groups
from .stations import StationPositions as StationPositions
