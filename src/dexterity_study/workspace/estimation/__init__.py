"""The confidence and the estimation network, sections V and VI of paper C."""
