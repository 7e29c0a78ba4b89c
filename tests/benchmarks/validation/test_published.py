"""Published numbers against computed ones."""

from benchmarks.validation.published import published


def test_every_number_is_met_but_the_known_misses():
    missed = [n for n in published() if not n.met]
    # They are discussed in the documentation. One that is met one day is a known miss no longer.
    assert missed == [n for n in published() if n.known_miss]
    assert [n.quantity for n in missed] == [
        "state of charge after 24 h",
        "minimum state of charge",
        "time flown",
    ]
