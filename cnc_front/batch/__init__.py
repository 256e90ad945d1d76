"""Batch dry-runs: many part programs on several machines, each pair a task of its own.

`parts` finds the programs, `pool` runs tasks in worker processes with limits, `store` keeps one row per task in SQLite,
`pages` writes what people and CI read, `compare` sets two batches side by side, `watch` serves a folder.
"""
