from . import initial as initial
from .damped import minimised as minimised
from .iteration import Solution as Solution
from .starts import Reached as Reached, reached as reached
