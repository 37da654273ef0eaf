"""From light to number: air, lens, film, marks and comparator, stage by stage, each to be switched off."""

from simfield.chain.film import RandomField
from simfield.chain.lens import Lens, RadialCertificate
from simfield.chain.machine import Comparator, Errors, Marks
from simfield.chain.measure import Chain, Prepared, prepare
from simfield.chain.presets import STAGES, chains, without
from simfield.chain.raw import Raw

__all__ = [
    "STAGES",
    "Chain",
    "Comparator",
    "Errors",
    "Lens",
    "Marks",
    "Prepared",
    "RadialCertificate",
    "RandomField",
    "Raw",
    "chains",
    "prepare",
    "without",
]
