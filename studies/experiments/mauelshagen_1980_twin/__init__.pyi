from .story import ReproductionError as ReproductionError, reproduce as reproduce
