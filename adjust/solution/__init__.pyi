from . import initial as initial
from .damped import minimised as minimised
from .determinability import judged as judged
from .iteration import Solution as Solution
