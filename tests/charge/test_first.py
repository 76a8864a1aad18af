from pathlib import Path

import pytest
import yaml

from pipeline.cell.records import Battery
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import BENCH, simulate

CONF = Path(__file__).parents[2] / "conf"


def load(path):
    data = yaml.safe_load((CONF / path).read_text())
    data.pop("sources", None)
    return data


@pytest.mark.parametrize("mode", ["cc_cv", "cv_reflex"])
def test_the_first_law_closes(mode):
    battery = Battery(**load("battery/lead_acid_12v7ah.yaml"))
    sheet = load(f"modes/{mode}.yaml")
    sheet["stop"]["elapsed_s"] = 60
    settings = ChargeSettings(initial_soc=0.9, ambient_c=25)
    charge = simulate(battery, Mode(**sheet), BENCH, settings, EngineSettings())
    values = {row.quantity: row.value for row in charge.summary}
    assert abs(values["energy_balance_residual"]) < 1e-9
