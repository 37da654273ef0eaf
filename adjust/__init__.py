"""From a block to estimates and their quality."""

from adjust import ap_models
from adjust.adjustment import Adjustment, ApEstimate, Estimates
from adjust.ap_models import ApModel
from adjust.bundle import adjust_block
from adjust.status import Status

__all__ = ["Adjustment", "ApEstimate", "ApModel", "Estimates", "Status", "adjust_block", "ap_models"]
