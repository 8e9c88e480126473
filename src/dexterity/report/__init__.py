"""What a chapter shows: verdicts on claims, scenes, figures, and where its numbers come from.

Each part is imported by its name, `from dexterity.report import claims, scenes`, so that a page loads
no more than it shows.
"""
