from . import initial as initial
from .determinability import judged as judged
from .iteration import Solution as Solution, solve as solve
