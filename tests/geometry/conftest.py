"""The command as in tests/app."""

from tests.app.conftest import cli

__all__ = ["cli"]
