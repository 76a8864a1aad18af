"""Panels by name: what pvlib's own reader finds, the paper's panel among them, and names that are not there."""

from __future__ import annotations

import numpy as np
import pytest
from pvlib.pvsystem import retrieve_sam

from pipeline.errors import UserError
from pipeline.panel.curves import agreement
from pipeline.panel.database import PanelEntry, by_words, look_up, names, reference
from pipeline.panel.records import Panel
from pipeline.panel.single_diode import fit


@pytest.mark.parametrize(("database", "pvlibs"), [("cec", "CECMod"), ("sandia", "SandiaMod")])
def test_the_names_are_pvlibs(database, pvlibs):
    assert names(database) == list(retrieve_sam(pvlibs).columns)


def test_every_module_of_the_cec_is_a_panel():
    for name in names("cec"):
        Panel.model_validate(look_up(PanelEntry(database="cec", name=name)))


def test_values_are_those_pvlib_reads():
    modules = retrieve_sam("CECMod")
    for name in np.random.default_rng(1).choice(modules.columns, 20, replace=False):
        theirs, panel = modules[name], Panel.model_validate(look_up(PanelEntry(database="cec", name=name)))
        diode = fit(panel)
        assert diode == (theirs.I_L_ref, theirs.I_o_ref, theirs.R_s, theirs.R_sh_ref, theirs.a_ref, theirs.Adjust)
        assert (panel.max_power_voltage_v, panel.cells_in_series) == (theirs.V_mp_ref, theirs.N_s)
        assert (panel.alpha_isc_a_per_k, panel.gamma_pmp_percent_per_k) == (theirs.alpha_sc, theirs.gamma_r)


def test_the_papers_panel_is_the_one_described_by_hand(kc65t):
    entry = PanelEntry(database="sandia", name="Kyocera_Solar_KC65T__2008__E__")
    found = Panel.model_validate(look_up(entry))
    assert found.max_power_w == pytest.approx(65.25)
    by_hand = kc65t.model_dump(exclude={"title", "max_power_w"})
    for name, value in found.model_dump(exclude={"title", "max_power_w"}).items():
        assert value == pytest.approx(by_hand[name], rel=1e-4), name
    assert "Kyocera_Solar_KC65T__2008__E__" in reference(entry)


def test_a_name_may_be_written_as_it_is_printed():
    printed = look_up(PanelEntry(database="cec", name="Kyocera Solar KC130GT", panels_in_series=2))
    assert printed == look_up(PanelEntry(database="cec", name="Kyocera_Solar_KC130GT", panels_in_series=2))


@pytest.mark.parametrize(
    ("database", "name", "words"),
    [
        ("cec", "Kyocera_KC130GT", ("'Kyocera_KC130GT'", "21535", "Kyocera_Solar_KC130GT")),
        ("cec", "kc130", ("Kyocera_Solar_KC130GT", "Kyocera_Solar_KC130TM")),
        ("cec", "?", ("none is close", "A10Green_Technology_A10J_S72_175")),
        ("sandia", "Kyocera_KC65", ("Sandia", "Kyocera_Solar_KC65T__2008__E__")),
        ("cec", "Canadian_Solar_CS5P", ("Canadian_Solar_Inc__CS5P_195M", "CS5P_200M", "panels canadian solar cs5p")),
        ("cec", "Kyocerra KC-130", ("Kyocera_Solar_KC130GT", "Kyocera_Solar_KC130TM")),
        ("cec", "SunPower_SPR_E20_327_X", ("SunPower_SPR_E20_327,", "panels sunpower spr e20 327")),
        ("cec", "Canadian_Solar_CS5P_220M___2009_", ("it stands in the Sandia", "panel.database=sandia")),
        ("cec", "KC65T", ("none is close", "panel.database=sandia", "Kyocera_Solar_KC65T__2008__E__")),
    ],
)
def test_an_unknown_name_lists_the_closest(database, name, words):
    with pytest.raises(UserError) as refused:
        look_up(PanelEntry(database=database, name=name))
    for word in words:
        assert word in str(refused.value)


def test_the_fit_shows_its_error(kc65t, diode):
    found = agreement(kc65t, diode)
    sheet, model = np.array(found["data_sheet"]), np.array(found["model"])
    points = [1, 2, 3, 4]  # the four the curve goes through; the printed power is rounded
    np.testing.assert_allclose(model[points], sheet[points], rtol=1e-8)
    assert model[0] / sheet[0] == pytest.approx(65.25 / 65.0, rel=1e-8)
    assert model[7] == pytest.approx(sheet[7], rel=1e-4)
    adjusted = (model[6] / sheet[6] - 1.0, 1.0 - model[5] / sheet[5])
    assert adjusted == pytest.approx((diode.adjust_percent / 100.0,) * 2, rel=2e-2)


@pytest.mark.parametrize("series", ["CS5P", "KD210GX", "SPR_E20", "TSM_250PA05"])
def test_a_series_is_offered_by_its_words_whoever_makes_it(series):
    known = [name for name in names("cec") if series in name]
    maker = known[0].split(series)[0].strip("_").split("_")[0]
    assert set(by_words(f"{maker} {series.lower()}", names("cec"))[: len(known)]) == set(known)


def test_what_is_offered_is_found_by_the_words_that_are_named():
    with pytest.raises(UserError) as refused:
        look_up(PanelEntry(database="cec", name="SunPower_SPR_E20_327_X"))
    words = str(refused.value).split("python -m pipeline panels ")[1].split()
    assert sum(all(word in name.lower() for word in words) for name in names("cec")) > 6
