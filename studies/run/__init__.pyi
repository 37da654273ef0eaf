from . import story as story
from .one_trial import condition_named as condition_named, replay as replay
from .story import How as How, run as run
from .verification import verify as verify
from .worker import BackendError as BackendError
