from .dotted_path import put as put
from .preset_scenarios import presets as presets
from .scenario import Scenario as Scenario, ScenarioError as ScenarioError
from .scenario_faults import fault_lines as fault_lines
from .scenario_file import (
    changed as changed,
    merged as merged,
    read_scenario as read_scenario,
    scenario_as_table as scenario_as_table,
    scenario_from_table as scenario_from_table,
)
