"""The studies behind the book: one module a chapter, a frozen config in and a frozen result out.

A study lies in the folder of its part and is found there; `dexterity.report.study.Study` says what it offers.
"""

from dexterity.studies.catalogue import STUDIES, acceptances, judged, verdicts, verdicts_by_study

__all__ = ["STUDIES", "acceptances", "judged", "verdicts", "verdicts_by_study"]
