"""Tables of winds that tests make up."""

from itertools import product

from missions.winds.table import COLUMNS


def winds_file(
    folder,
    wind,
    *,
    latitudes=(-90, 90),
    altitudes_m=(0, 2000),
    months=range(1, 13),
    percentiles=(95,),
):
    """Write ``wind(latitude, altitude, month, percentile)`` of all of them; return the path."""
    places = product(latitudes, altitudes_m, months, percentiles)
    rows = [",".join(map(str, (*place, wind(*place)))) for place in places]
    text = "\n".join([",".join(COLUMNS), *rows])
    path = folder / f"winds-{hash(text)}.csv"
    path.write_text(text, encoding="utf-8")
    return str(path)
