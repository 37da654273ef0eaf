from . import detection_page as detection_page, error_budget_page as error_budget_page
from .reproduction import Reproduction as Reproduction, ReproductionError as ReproductionError
