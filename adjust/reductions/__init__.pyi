from .air import (
    MEAN_RADIUS_M as MEAN_RADIUS_M,
    bending as bending,
    earth_curvature as earth_curvature,
    refraction as refraction,
)
from .comparator import (
    DoubleMeasurement as DoubleMeasurement,
    calibrated as calibrated,
    double_measurement as double_measurement,
    drift as drift,
)
from .inner import (
    PARAMETERS as PARAMETERS,
    InnerOrientation as InnerOrientation,
    Kind as Kind,
    inner_orientation as inner_orientation,
)
from .lens import decentering as decentering, displaced as displaced, radial as radial, tilt as tilt
from .lens_and_air_compiled import optics as optics, without_lens_and_air as without_lens_and_air
from .reduce_compiled import (
    Frame as Frame,
    Work as Work,
    drift_weights as drift_weights,
    oriented as oriented,
    reduced as reduced,
)
from .reduced_points import Reduced as Reduced
from .reduction import (
    REDUCTIONS as REDUCTIONS,
    ReducedBlock as ReducedBlock,
    ReductionPlan as ReductionPlan,
    marks_of as marks_of,
    reduce as reduce,
    through_lens_and_air as through_lens_and_air,
)
from .reseau_crosses import reseau as reseau
