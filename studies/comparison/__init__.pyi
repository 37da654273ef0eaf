from . import block_views as block_views, distortion_found as distortion_found, measures as measures
from .block_views import (
    PointErrors as PointErrors,
    ap_exterior_correlations as ap_exterior_correlations,
    mean_residuals as mean_residuals,
    point_errors as point_errors,
)
from .distortion_found import (
    CREST_RADII_MM as CREST_RADII_MM,
    DECENTERING as DECENTERING,
    RADIAL as RADIAL,
    DecenteringFields as DecenteringFields,
    RadialCurve as RadialCurve,
    VectorField as VectorField,
    crest as crest,
    decentering_fields as decentering_fields,
    format_grid as format_grid,
    radial_curve as radial_curve,
)
from .measures import (
    CONFIDENCE as CONFIDENCE,
    geodetic_deviations as geodetic_deviations,
    root_mean_square as root_mean_square,
)
