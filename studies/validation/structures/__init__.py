"""Published masses of built aircraft beside those of the rib wing, from 3 to 75 m of span."""
