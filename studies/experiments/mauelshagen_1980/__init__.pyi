from . import drawings as drawings, experiment as experiment, table1 as table1, trials as trials
from .experiment import (
    CAMERAS as CAMERAS,
    SECTIONS as SECTIONS,
    Row as Row,
    adjusted as adjusted,
    middle_images as middle_images,
    rows as rows,
    sub_block as sub_block,
)
from .story import OLDER as OLDER, reproduce as reproduce
from .table1 import table1_markdown as table1_markdown
from .trials import places as places, run_trials as run_trials
from .written import write_provenance as write_provenance
