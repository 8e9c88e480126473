"""The workspace of a PUMA 560 and a control loop on it, sections I, VI.C and VII of paper C."""
