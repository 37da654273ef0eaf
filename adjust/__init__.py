"""From a block to estimates and their quality."""

from adjust import ap_models
from adjust.adjustment import Adjustment, ApEstimate, Estimates
from adjust.ap_models import ApModel
from adjust.bundle import adjust_block
from adjust.replicates import Replicates, adjust_replicates
from adjust.status import Status

__all__ = [
    "Adjustment",
    "ApEstimate",
    "ApModel",
    "Estimates",
    "Replicates",
    "Status",
    "adjust_block",
    "adjust_replicates",
    "ap_models",
]
