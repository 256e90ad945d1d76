"""The pages, one module each; this table is what the application knows of them."""

from __future__ import annotations

from tui.pages.alarms import AlarmsPage
from tui.pages.base import Page
from tui.pages.help import HelpPage
from tui.pages.jobs import JobsPage
from tui.pages.manual import ManualPage
from tui.pages.mdi import MdiPage
from tui.pages.report import ReportPage
from tui.pages.run import RunPage
from tui.pages.service import ServicePage

#: Their keys F1 ... F8 stand in tui.keys.
PAGES: tuple[type[Page], ...] = (HelpPage, JobsPage, RunPage, ManualPage, MdiPage, AlarmsPage, ReportPage, ServicePage)

__all__ = ["PAGES", "Page", "RunPage"]
