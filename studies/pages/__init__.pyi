from . import models_page as models_page, study_report as study_report
from .html_report import report as report
from .models_page import describe as describe
from .scenario_sheet import scenario_page as scenario_page
