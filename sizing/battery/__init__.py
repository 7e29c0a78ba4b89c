"""The battery of an aircraft's file: cells, charge limit, voltage, temperature and age."""
