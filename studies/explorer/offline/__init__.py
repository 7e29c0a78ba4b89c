"""Explorer in a single file: tables computed beforehand, read by the page without a server."""
