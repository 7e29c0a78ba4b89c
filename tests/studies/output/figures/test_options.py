"""Size, resolution and style of figures, as options and in Python."""

import os
import re
import subprocess
import sys
from pathlib import Path

import matplotlib as mpl
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from refusals import refusals

import missions
import sizing
import studies
from studies.output.figures.drawing import read_style, to_bytes
from studies.output.figures.options import SHIPPED_STYLES, FigureOptions, in_style, read_size

AS2 = "atlantiksolar-as2"


@pytest.fixture(scope="module")
def analysis():
    return sizing.analyse(sizing.load_aircraft(AS2), missions.load_mission("rafz-july"))


@pytest.mark.parametrize(
    ("text", "size_in"),
    [
        ("170x100mm", (170 / 25.4, 100 / 25.4)),
        ("17X10cm", (170 / 25.4, 100 / 25.4)),
        ("7×4.5in", (7.0, 4.5)),
        ("85 mm", (85 / 25.4, None)),
    ],
)
def test_sizes_are_read_in_mm_cm_and_inches(text, size_in):
    assert read_size(text) == pytest.approx(size_in)


@pytest.mark.parametrize("text", ["170x100", "170x-3mm", "nanxnanin", "1x1m", "10x10mm", "9x999in"])
def test_other_sizes_are_refused(text):
    with pytest.raises(ValueError, match=r"mm"):
        read_size(text)


def test_an_image_too_large_for_the_memory_is_refused(run):
    with pytest.raises(ValueError, match="at most 65535"):
        FigureOptions(size_in=(60.0, None), dots_per_inch=1200.0)
    with pytest.raises(ValueError, match="2304 million dots, at most 150 million"):
        FigureOptions(size_in=(40.0, 40.0), dots_per_inch=1200.0)
    # 8 x 4.8 in, which is known when it is drawn
    told = run("analyse", AS2, "--plot", "large.png", "--dpi", "2400")
    assert told.code == 2
    assert "million can be drawn" in told.err
    assert not Path("large.png").exists()


@pytest.mark.parametrize("style", [*SHIPPED_STYLES, "grayscale"])
def test_styles_draw_with_embedded_truetype(style):
    settings = FigureOptions(style=read_style(style)).settings()
    assert settings["pdf.fonttype"] == settings["ps.fonttype"] == 42


@pytest.mark.parametrize(
    ("_", "text", "message"),
    [
        *refusals(Path(__file__).with_name("style_mistakes.txt")),
        ("", "#" * 100_001, "'bad.mplstyle' is neither a style nor a file of one"),
    ],
)
def test_mistakes_of_a_style_file_are_told_by_line(tmp_path, monkeypatch, _, text, message):
    monkeypatch.chdir(tmp_path)
    Path("bad.mplstyle").write_text(text.replace("\\n", "\n"))
    with pytest.raises(ValueError, match=re.escape(message)):
        read_style("bad.mplstyle")
    os.mkfifo("pipe")
    with pytest.raises(ValueError, match="is neither a style nor a file of one"):
        read_style("pipe")


def test_a_figure_has_the_size_and_the_fonts_that_were_asked_for(analysis):
    asked = FigureOptions(size_in=read_size("170x100mm"), style="paper", title=False)
    before = dict(mpl.rcParams)
    figure = studies.plot_cycle(analysis, figure=asked)
    assert dict(mpl.rcParams) == before
    assert figure.get_suptitle() == ""
    assert not figure.texts
    pdf = to_bytes(figure, "pdf")
    width, height = (float(n) for n in re.findall(rb"MediaBox \[\s*0 0 (\S+) (\S+)", pdf)[0])
    assert (width, height) == pytest.approx((72 * 170 / 25.4, 72 * 100 / 25.4))
    assert b"/FontFile2" in pdf  # TrueType, Type 42
    assert b"/Type3" not in pdf


@pytest.mark.long
def test_the_command_reads_no_settings_of_its_folder(tmp_path):
    written = []
    # The last one is no text, on which the import of matplotlib fails.
    for number, settings in enumerate([None, b"text.usetex: True\nno.key: 1\n", b"\xff\xfe\x00"]):
        folder = tmp_path / str(number)
        folder.mkdir()
        if settings is not None:
            (folder / "matplotlibrc").write_bytes(settings)
        start = "from studies.cli.start import start; start()"
        command = [sys.executable, "-c", start, "analyse", AS2, "--plot", "a.png", "--dpi", "40"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (0, ""), done.stderr
        assert done.stdout.endswith("written to a.png\n")
        written.append((folder / "a.png").read_bytes())
    assert written[1:] == written[:1] * 2


def test_a_figure_is_drawn_onto_one_that_is_given(analysis):
    mine = Figure(figsize=(5.0, 5.0), layout="constrained")
    with in_style(FigureOptions(style="dark")):
        assert studies.plot_cycle(analysis, figure=mine) is mine
    assert len(mine.axes) == 2


def test_the_command_draws_in_the_size_that_is_asked_for(run):
    size = ["--figure-size", "100x80mm", "--dpi", "50", "--style", "paper", "--no-title"]
    assert run("analyse", AS2, "--plot", "a.png", *size).code == 0
    header = Path("a.png").read_bytes()[16:24]
    wide, high = (int.from_bytes(part, "big") for part in (header[:4], header[4:]))
    assert (wide, high) == pytest.approx((100 / 25.4 * 50, 80 / 25.4 * 50), abs=1)


@pytest.mark.long
@pytest.mark.parametrize(
    "call",
    [
        "uncertainty atlantiksolar-design --samples 64 --figure-size 60x42mm",
        # Its heading fills it.
        "analyse atlantiksolar-as2 --figure-size 41x40mm --style slides",
    ],
)
def test_a_figure_too_small_for_its_axes_is_told_and_written(run, tmp_path, call):
    outcome = run(*call.split(), "--plot", "out.pdf")
    assert outcome.code == 0
    assert "the figure is too small for its axes and texts: give a larger" in outcome.err
    assert "Warning" not in outcome.err
    assert (tmp_path / "out.pdf").exists()


@pytest.mark.long
def test_settings_of_the_user_change_nothing_of_a_figure_that_is_shown(analysis):
    """Drawn by a canvas, as a notebook does; on the user's own figure they hold throughout."""
    where = {"latitudes": [40, 50, 60], "days": [80, 172, 264]}
    data = studies.feasibility_map(analysis.aircraft, analysis.mission, **where)

    def drawn():
        shown = []
        for figure in (studies.plot_cycle(analysis), studies.plot_map(data)):
            canvas = FigureCanvasAgg(figure)
            canvas.draw()
            shown.append(bytes(canvas.buffer_rgba()))
        return shown

    with mpl.rc_context({}):
        plain = drawn()
        saved = to_bytes(studies.plot_cycle(analysis), "png")
    own = {"font.size": 22.0, "text.color": "red", "image.cmap": "magma", "axes.grid": True}
    machine = {"axes.facecolor": "red", "text.usetex": True}
    machine |= {"savefig.pad_inches": 2.0, "savefig.transparent": True, "path.sketch": (9, 9, 9)}
    with mpl.rc_context(own | machine):
        assert to_bytes(studies.plot_cycle(analysis), "png") == saved
    with mpl.rc_context(own):
        assert drawn() == plain
        given = Figure()
        studies.plot_cycle(analysis, figure=given)
        canvas = FigureCanvasAgg(given)
        canvas.draw()
        assert {text.get_color() for text in given.texts} <= {"red"}
        assert given.axes[0].xaxis.label.get_fontsize() == 22.0


def test_a_figure_takes_the_place_of_given_axes(analysis):
    whole = Figure(figsize=(12, 5), layout="constrained")
    left, right = whole.subplots(1, 2)
    right.plot([0, 1], [0, 1])
    part = studies.plot_cycle(analysis, ax=left)
    masses = studies.plot_masses({"battery": 2.0, "wing": 1.0}, "masses", figure=Figure())
    assert left not in whole.axes
    assert right in whole.axes
    assert part.axes
    FigureCanvasAgg(whole).draw()
    for axes in part.axes:
        assert axes.get_window_extent().x1 < right.get_window_extent().x0
    assert masses.axes
    with pytest.raises(ValueError, match="ax must be axes of a grid"):
        studies.plot_cycle(analysis, ax=Figure().add_axes((0, 0, 1, 1)))
