from .experiment import ReproductionError as ReproductionError
from .story import Reproduction as Reproduction, reproduce as reproduce
