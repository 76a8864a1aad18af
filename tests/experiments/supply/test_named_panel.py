"""A panel by its name on the command line: values, sources and mistakes."""

from __future__ import annotations

from typing import Any

import pytest

from pipeline.config.compose import compose_tree
from pipeline.config.study import study_from
from pipeline.errors import UserError


def composed(*words: str) -> Any:
    return study_from(compose_tree(words))


def test_a_name_alone_is_enough_and_every_value_has_its_source() -> None:
    study = composed("panel.name=Kyocera_Solar_KC130GT")
    assert study.panel is not None
    assert study.panel.title == "Kyocera Solar KC130GT"
    assert study.panel.single_diode is not None
    for path in ("panel.max_power_w", "panel.single_diode.photocurrent_a", "panel.cells_in_series"):
        assert study.sources[path].kind == "data_sheet"
        assert "Kyocera_Solar_KC130GT" in study.sources[path].ref
    assert study.sources["panel.panels_in_series"].kind == "derived"
    assert study.configuration["panel"]["max_power_voltage_v"] == 17.6


def test_the_study_knows_only_the_values() -> None:
    by_name = composed("panel=database", "panel.database=sandia", "panel.name=Kyocera_Solar_KC65T__2008__E__")
    assert by_name.panel is not None
    assert by_name.panel.single_diode is None
    assert "name" not in by_name.configuration["panel"]


MISTAKES = {
    ("panel.name=Kyocera_KC130GT",): ("override panel.name=Kyocera_KC130GT: panel.name", "Kyocera_Solar_KC130GT"),
    ("panel=database", "panel.database=nrel"): ("panel.database", "'nrel'", "cec, sandia"),
    ("panel.database=sandia",): ("panel.database", "give its name beside it, panel.name=NAME"),
    ("panel.name=kc65t",): ("no panel 'kc65t'", "conf/panel/kc65t.yaml is chosen with panel=kc65t"),
    ("panel=database", "panel.panels_in_series=0"): ("panel.panels_in_series", "1 or more", "0"),
    ("panel=database", "panel.nam=x"): ("panel has no key 'nam'", "name"),
    ("panel.name=A10Green_Technology_A10J_S72_175",): ("converter.bus_voltage_v", "24", "36.63"),
    ("tracker@trackers.perturb_observe=perturb_observ",): ("conf/tracker/perturb_observ.yaml", "perturb_observe"),
    ("trackers.perturb_observe.duty_step=2",): ("trackers.perturb_observe.duty_step", "2", "0.2"),
    ("trackers.particle_swarm.chaos_start=0.5",): ("trackers.particle_swarm", "0.5", "0.75"),
    ("trackers.variable_step.least_duty=0.95",): ("trackers.variable_step", "least_duty", "0.95", "most_duty"),
    ("tracking.ramps.whole_range.repetitions=[1]",): ("tracking.ramps.whole_range", "repetitions", "2 slopes"),
    ("tracking.ramps.whole_range.low_w_m2=1200",): ("tracking.ramps.whole_range", "1200", "1000"),
    ("tracking.shading.scenes.half_shadow=[1000]",): ("tracking.shading", "scenes.half_shadow", "two"),
    ("tracking.shown_slope_w_m2_s=7.5",): ("tracking", "shown_slope_w_m2_s", "7.5"),
    ("converter=parts", "converter.losses=null"): ("boost.kind is parts", "losses"),
    ("converter.losses.boost.ripple_exponent=9",): ("converter.losses.boost.ripple_exponent", "9"),
}


@pytest.mark.parametrize("mistake", MISTAKES, ids=" ".join)
def test_a_mistake_names_key_value_and_what_is_allowed(mistake: tuple[str, ...]) -> None:
    with pytest.raises(UserError) as refused:
        composed(*mistake)
    for word in MISTAKES[mistake]:
        assert word in str(refused.value), str(refused.value)


def test_converters_of_parts_reach_the_supply_and_others_do_not() -> None:
    from pipeline.kernel.draft import drafts

    for words, expected in (((), None), (("converter=parts",), 18e-5)):
        node = next(node for node in drafts(composed(*words)) if node.name == "supply")
        switched = node.settings["converter"]["switched"]
        assert (switched and switched["boost"]["inductance_h"]) == expected
