"""Weather records: light, temperature and wind at a site over time, from files."""
