from .gross_errors import (
    LEAST_CHECKED as LEAST_CHECKED,
    Accused as Accused,
    Snooping as Snooping,
    snoop as snoop,
)
from .inspection import LEVEL as LEVEL, Inspection as Inspection, inspected as inspected
from .model_choice import (
    aic as aic,
    bic as bic,
    delete_stepwise as delete_stepwise,
    leave_one_image_out as leave_one_image_out,
)
from .reliability import (
    ALPHA as ALPHA,
    POWER as POWER,
    Reliability as Reliability,
    familywise as familywise,
    noncentrality as noncentrality,
    tau_critical as tau_critical,
    tau_noncentrality as tau_noncentrality,
    w_critical as w_critical,
)
from .robust_estimation import Cauchy as Cauchy, Danish as Danish, Huber as Huber, robust as robust
from .significance import (
    ApSignificance as ApSignificance,
    FTest as FTest,
    ap_significance as ap_significance,
    finer_sets as finer_sets,
    global_test as global_test,
)
from .variance import (
    VarianceComponents as VarianceComponents,
    groups_by_camera as groups_by_camera,
    variance_components as variance_components,
)
