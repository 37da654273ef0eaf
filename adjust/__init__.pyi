from . import ap_models as ap_models, quality as quality, reductions as reductions
from .adjustment import (
    Adjustment as Adjustment,
    ApEstimate as ApEstimate,
    Estimates as Estimates,
    correlations as correlations,
)
from .ap_models import ApModel as ApModel
from .bundle import adjust_block as adjust_block, reweighted as reweighted
from .datum import (
    MOTIONS as MOTIONS,
    ByControl as ByControl,
    FreeAdjustment as FreeAdjustment,
    InnerConstraints as InnerConstraints,
    MinimumControl as MinimumControl,
)
from .status import Status as Status
from .trials import Replicates as Replicates, adjust_replicates as adjust_replicates
