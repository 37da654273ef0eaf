from . import (
    drawings as drawings,
    gross_error as gross_error,
    interval as interval,
    own_block as own_block,
    redundancy as redundancy,
    second_zero as second_zero,
    which_model as which_model,
)
from .apps.picture import picture as picture
from .lesson import LessonError as LessonError
from .serving.server import serve as serve
