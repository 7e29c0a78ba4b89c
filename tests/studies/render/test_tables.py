"""Tables and summaries: one description, the same content for every reader."""

import io
import math

import pandas as pd
import pytest

from studies.render.tables import Column, Grid, Line, Summary, Table, clock_label, facts
from studies.render.words import change_text, date_and_clock

COLUMNS = (Column("item"), Column("mass_kg", "mass", "kg", ".3f"))
MASSES = Table("mass budget", COLUMNS, (("structure", 0.7081), ("battery", None)), ("a note",))


def test_text_has_headings_with_units_values_and_notes():
    lines = MASSES.to_text().splitlines()
    assert lines[0].strip() == "mass budget"
    assert lines[1].split() == ["item", "mass", "[kg]"]
    assert lines[3].split() == ["structure", "0.708"]
    assert lines[4].split() == ["battery", "-"]
    assert lines[5] == "a note"
    assert len(lines[3]) == len(lines[1])  # numbers are aligned to the right


def test_text_keeps_to_its_width_without_losing_words():
    words = [f"word{i}" for i in range(40)]
    text = Summary((" ".join(words), MASSES)).to_text(width=30)
    assert max(map(len, text.splitlines())) <= 30
    assert all(word in text.split() for word in words)


def test_values_are_text_for_people():
    column = Column("excess_time_h", "excess time", "h", ".2f")
    assert column.heading == "excess time [h]"
    assert [column.text(v) for v in (1.0, None, math.nan, math.inf, -math.inf, "x", True)] == [
        *("1.00", "-", "-", "unlimited", "-unlimited", "x", "yes")
    ]
    assert Column("share", form="{:.0%} of it").text(0.5) == "50% of it"


def test_hours_are_clock_readings_with_the_date_where_days_count():
    assert [clock_label(h) for h in (6.5, 0.0, 23.75, 24.0)] == ["06:30", "00:00", "23:45", "24:00"]
    # A quarter past one in the night after 21 June, day 172.
    assert date_and_clock(25.25, 172) == "22 Jun 01:15"
    assert [clock_label(h) for h in (None, math.nan, math.inf)] == ["-", "-", "-"]


def test_csv_and_frame_keep_all_digits_under_the_columns_names():
    frame = MASSES.to_frame()
    assert list(frame.columns) == ["item", "mass_kg"]
    assert frame["mass_kg"][0] == 0.7081
    assert frame.attrs == {"title": "mass budget", "units": {"mass_kg": "kg"}}
    pd.testing.assert_frame_equal(
        pd.read_csv(io.StringIO(MASSES.to_csv())), pd.DataFrame(frame), check_dtype=False
    )


def test_markdown_is_a_table_whatever_the_cells_hold():
    lines = Table("", COLUMNS, (("a|b", 1.0),)).to_markdown().splitlines()
    assert lines == ["| item | mass [kg] |", "| --- | ---: |", "| a\\|b | 1.000 |"]


def test_html_escapes_names_and_text_leaves_them():
    page = Summary((Line("<b>", "strong"), facts("", [("<script>", "&")]))).to_html()
    assert "<script>" not in page
    assert "&lt;script&gt;" in page
    assert "<p>&lt;b&gt;</p>" in page
    assert "[bold]x[/bold] :smile:" in Summary(("[bold]x[/bold] :smile:",)).to_text()
    assert "[red]" in facts("[red]", [("[link]", "v")]).to_text()


def test_tables_stand_side_by_side_where_there_is_room():
    left, right = facts("", [("wingspan", "4 m")]), facts("", [("battery", "2 kg")])
    assert Summary(((left, right),)).to_text().splitlines() == ["wingspan  4 m     battery  2 kg"]


def test_a_row_of_another_length_is_refused():
    with pytest.raises(ValueError, match="mass budget: a row has 1 values for 2 columns"):
        Table("mass budget", COLUMNS, (("structure",),))


WIDE = Table(
    "",
    (
        Column("condition"),
        Column("where"),
        *(Column(f"quantity_{i}", f"quantity number {i}", "kg", ".3f") for i in range(9)),
        Column("design_space.maximum_total_mass_kg"),
    ),
    tuple(
        (f"clear and calm, {i}.5 m/s of wind", "45° N, 15 Aug", *[1000.0 + i] * 9, "no")
        for i in range(3)
    ),
    ("a note of some words that goes on for longer than a narrow line would hold in any case",),
    sections=(1,),
)


@pytest.mark.parametrize("width", [40, 60, 80, 120, 400])
def test_no_word_is_broken_and_no_line_is_too_long(width):
    text = WIDE.to_text(width)
    assert max(map(len, text.splitlines())) <= width
    words = set(text.split())
    wanted = [column.heading for column in WIDE.columns] + [c for r in WIDE.texts() for c in r]
    assert set(" ".join(wanted).split()) <= words
    assert not any(line != line.rstrip() for line in text.splitlines())


def test_columns_that_do_not_fit_stand_below_under_the_names_of_the_rows():
    blocks = WIDE.to_text(60).split("\n\n")
    heads = [block for block in blocks if "condition" in block]
    assert len(heads) > 1
    assert all("where" in block for block in heads)


def test_numbers_keep_their_units_and_days_their_months():
    for width in range(20, 60):
        text = Summary(("an excess time of 6.26 h on 15 Aug at 47.6° N with 7 % less sun",))
        lines = text.to_text(width).splitlines()
        assert not {line.split()[-1] for line in lines} & {"6.26", "15", "47.6", "7"}


def test_items_are_indented_further_on_their_second_line():
    lines = Summary(("  one two three", "- four five six")).to_text(10).splitlines()
    assert lines == ["  one two", "    three", "- four", "  five six"]


def test_texts_of_cells_are_broken_no_more_than_the_width_asks_for():
    grid = Grid(("part", "text"), [("wing", "one two three four five six")], (False, False))
    assert [line.split() for line in grid.lines(24)[2:]] == [
        ["wing", "one", "two", "three", "four"],
        ["five", "six"],
    ]
    assert Grid(None, (("a",),), (False,))._least_width(0, whole_cell=False) == 1


def test_a_change_has_a_sign_where_it_can_be_seen():
    changes = {(2.0, 2.1): "+5.0 %", (2.0, 1.9): "-5.0 %", (0.0, 1.0): "-"}
    changes |= {(2.0, 2.0001): "0.0 %", (2.0, 1.9999): "0.0 %"}
    assert {pair: change_text(*pair) for pair in changes} == changes
