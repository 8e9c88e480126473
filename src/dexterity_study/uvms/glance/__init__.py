"""The pipeline of paper A at a glance: one picture of each step, for one seed."""
