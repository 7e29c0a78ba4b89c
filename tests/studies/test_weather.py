import pytest
from weather_files import clear_record

import sizing
import studies
from missions.library import load_mission
from sizing.library import load_aircraft


@pytest.mark.long
@pytest.mark.parametrize(("days", "share"), [(40, 1.0), (5, 0.2), (800, 0.9)])
def test_calendar_survival_and_season_are_drawn(days, share, tmp_path):
    record = clear_record(days, first="2001-07-14", share=share)
    analysis = sizing.analyse_weather(
        load_aircraft("atlantiksolar-as2"), load_mission("rafz-july"), record
    )
    figure = studies.plot_weather(analysis)
    calendar, survival, season, bar = figure.axes
    closes = analysis.performance.recorded.closes.any()
    assert closes or share == 0.2
    quantity = "state of charge at dawn [%]" if closes else "flown from dawn [h]"
    assert bar.get_ylabel() == quantity
    assert survival.get_xlabel() == "time since the launch at dawn [d]"
    assert season.get_ylabel() == "days that close [%]"
    image = calendar.images[0].get_array()
    assert image.count() == days - int(closes)  # the full battery of the start is no charge at dawn
    years = days > 400
    names = [tick.get_text() for tick in calendar.get_yticklabels()]
    assert names[0] == ("2001" if years else "Jul")
    failed = int((~analysis.performance.recorded.closes).sum())
    marks = {line.get_label(): line.get_xdata() for line in calendar.lines}
    assert len(marks.get("does not close", ())) == (failed if closes else 0)
    assert ("windows of consecutive days" in str(analysis.at_level(2))) == closes
    studies.save_figure(figure, tmp_path / "a.png")
