"""Figure of flights under uncertain inputs."""
