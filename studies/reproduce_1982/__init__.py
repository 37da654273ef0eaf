"""Ziemann & El-Hakim 1982, flown and adjusted again: their comparison of sets of additional parameters."""

from studies.reproduce_1982.experiment import ReproductionError
from studies.reproduce_1982.story import Reproduction, reproduce

__all__ = ["Reproduction", "ReproductionError", "reproduce"]
