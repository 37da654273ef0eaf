from . import properties as properties
from .lookup import MODELS as MODELS, get as get, names as names
from .model import ApModel as ApModel, Certainty as Certainty
from .own import own_model as own_model
from .restricted import without as without
