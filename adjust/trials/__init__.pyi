from . import replicates as replicates
from .chord import Chord as Chord
from .replicates import (
    Replicates as Replicates,
    adjust_prepared as adjust_prepared,
    adjust_replicates as adjust_replicates,
    prepared as prepared,
)
from .solved import STATUSES as STATUSES
