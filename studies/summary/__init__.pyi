from . import (
    performance as performance,
    ranking as ranking,
    stopping as stopping,
    summary as summary,
    summary_file as summary_file,
)
from .cells import Cell as Cell
from .stopping import trials_of as trials_of
from .summary import Row as Row, Summary as Summary, summarise as summarise
from .summary_file import NothingToReportError as NothingToReportError
