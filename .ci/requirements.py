"""Prints what pyproject.toml requires, one a line, for `pip install -r`: the tables stay there and only there."""

import sys
import tomllib
from pathlib import Path

project = tomllib.loads((Path(__file__).parent.parent / "pyproject.toml").read_text("utf-8"))
tables = {
    "build": project["build-system"]["requires"],
    "run": project["project"]["dependencies"],
    "dev": project["project"]["optional-dependencies"]["dev"],
}
print(*(requirement for name in sys.argv[1:] for requirement in tables[name]), sep="\n")
