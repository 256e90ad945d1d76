"""Checks against drawing, blank and fixtures: files, options and results. The geometry stands in toolpaths."""
