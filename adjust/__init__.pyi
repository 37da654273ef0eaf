from . import ap_models as ap_models
from .adjustment import Adjustment as Adjustment, ApEstimate as ApEstimate, Estimates as Estimates
from .ap_models import ApModel as ApModel
from .bundle import adjust_block as adjust_block
from .replicates import Replicates as Replicates, adjust_replicates as adjust_replicates
from .status import Status as Status
