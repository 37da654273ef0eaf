from . import (
    performance as performance,
    ranking as ranking,
    stopping as stopping,
    summary as summary,
    summary_file as summary_file,
)
from .cells import Cell as Cell
from .measure_names import measure_faults as measure_faults
from .monte_carlo_errors import (
    bootstrap_error as bootstrap_error,
    mean_error as mean_error,
    quantile_error as quantile_error,
)
from .over_geometries import error_of as error_of
from .stopping import trials_of as trials_of
from .summary import Row as Row, Summary as Summary, summarise as summarise
from .summary_file import NothingToReportError as NothingToReportError
