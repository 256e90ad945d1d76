"""The process engineer's report: one HTML file, the same figures as JSON, a table of blocks, pictures."""

from cnc_front.report.build import write_report
from cnc_front.report.data import ReportInput

__all__ = ["ReportInput", "write_report"]
