import csv
import io

DESIGN = "atlantiksolar-design"


def test_probability_percentiles_and_causes(run, tmp_path):
    table, figure = tmp_path / "draws.csv", tmp_path / "draws.png"
    done = run("uncertainty", DESIGN, "--samples", "128", "--csv", table, "--plot", figure).good()
    assert "probability of perpetual flight" in done.out
    rows = list(csv.DictReader(io.StringIO(table.read_text())))
    assert len(rows) == 128
    assert figure.read_bytes().startswith(b"\x89PNG")
