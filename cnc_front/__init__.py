"""The application: command line, machine files, runs, recordings, reports."""

VERSION = "0.1.0"
