"""The best design that closes a share of the days of a season, as a weather record has them."""
