"""A twin of 1969: worlds in which Table 1 of Mauelshagen 1980 happens. They could have been; nobody says they were."""

from studies.reproduce_1980.experiment import ReproductionError
from studies.twin_1980.story import reproduce

__all__ = ["ReproductionError", "reproduce"]
