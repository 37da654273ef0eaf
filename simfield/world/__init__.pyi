from .cameras import RC8R as RC8R, RMK_AR as RMK_AR, SWW as SWW, WW as WW, CameraModel as CameraModel
from .fields import (
    FIELDS as FIELDS,
    Control as Control,
    Field as Field,
    FieldPoints as FieldPoints,
    GroupSize as GroupSize,
    Layout as Layout,
    Quincunx as Quincunx,
    RegularGrid as RegularGrid,
    Relief as Relief,
)
from .flights import (
    Flight as Flight,
    FlightPlan as FlightPlan,
    deviation as deviation,
    fly as fly,
    plan_flights as plan_flights,
)
from .imaging import half_format as half_format, ideal_image as ideal_image
from .measurement import (
    CountError as CountError,
    Measurement as Measurement,
    PointCount as PointCount,
    Rays as Rays,
    measured_rays as measured_rays,
)
