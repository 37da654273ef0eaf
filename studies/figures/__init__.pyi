from .canvas import (
    BLACK as BLACK,
    BLUE as BLUE,
    COLOURS as COLOURS,
    GREEN as GREEN,
    GREY as GREY,
    MARKERS as MARKERS,
    ORANGE as ORANGE,
    VERMILION as VERMILION,
    house_style as house_style,
    literal as literal,
    new_figure as new_figure,
    save as save,
    svg as svg,
)
from .ground import (
    error_ellipses as error_ellipses,
    field_plan as field_plan,
    rays_bar as rays_bar,
    rays_per_point as rays_per_point,
)
from .images import (
    HALF_FORMAT_MM as HALF_FORMAT_MM,
    POINT_UNIT_MM as POINT_UNIT_MM,
    correlation_matrix as correlation_matrix,
    correlation_rectangle as correlation_rectangle,
    falling_errors as falling_errors,
    lines as lines,
    radial_curve as radial_curve,
    radial_frame as radial_frame,
    radius_histogram as radius_histogram,
    ranges as ranges,
    true_radial_curve as true_radial_curve,
    vectors as vectors,
)
from .over_factors import (
    MANY_LABELS as MANY_LABELS,
    MOST_SERIES as MOST_SERIES,
    measure_over_factor as measure_over_factor,
    series_of as series_of,
    with_unit as with_unit,
)
from .trials import INTERVAL as INTERVAL, lollipops as lollipops, nested_loop as nested_loop, zip_plot as zip_plot
