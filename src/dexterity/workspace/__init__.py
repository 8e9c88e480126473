"""What an arm reaches, learned from samples and exactly: paper C."""

from dexterity.workspace.reachability import reachable

__all__ = ["reachable"]
