"""Proved bounds of the errors of the shipped networks for w and KCI."""
