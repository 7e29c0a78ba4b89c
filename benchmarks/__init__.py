"""Speed measured as ratios against peers and bounds in one process."""
