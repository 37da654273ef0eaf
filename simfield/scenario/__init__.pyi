from .dotted_path import put as put
from .scenario import Scenario as Scenario, ScenarioError as ScenarioError
from .scenario_file import (
    changed as changed,
    scenario_as_table as scenario_as_table,
    scenario_from_table as scenario_from_table,
)
