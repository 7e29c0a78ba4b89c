"""The version of the distribution, read by the build backend and by the package."""

__version__ = "2.0.0"
