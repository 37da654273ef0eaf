from . import shipped as shipped
from .conditions import Condition as Condition, factor_names as factor_names
from .factors import factor_named as factor_named, level_label as level_label
from .measuring import Measuring as Measuring, fitting as fitting
from .methods import ALL as ALL, Method as Method, references as references
from .plan import SCHEMA as SCHEMA, BlockTask as BlockTask, Plan as Plan
from .study import Study as Study, StudyError as StudyError
from .study_file import read_study as read_study
