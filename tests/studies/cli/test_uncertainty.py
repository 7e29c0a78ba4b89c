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


def test_json_has_what_scripts_need(run):
    record = run("uncertainty", DESIGN, "--samples", "128", "--seed", "5", "--json").json()
    assert set(record["probability_perpetual"]) == {"value", "low", "high"}
    assert set(record["excess_time_h"]) == {"p10", "p50", "p90"}
    assert set(record["sobol"]["modules.efficiency_stc"]) == {"first", "total"}
    assert (record["samples"], record["seed"]) == (128, 5)
