"""Mauelshagen 1980, flown and adjusted again: its tables, claims and figures beside the published ones."""

from studies.reproduce_1980.experiment import ReproductionError
from studies.reproduce_1980.story import Reproduction, reproduce

__all__ = ["Reproduction", "ReproductionError", "reproduce"]
