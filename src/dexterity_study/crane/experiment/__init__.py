"""The measurements on a real crane, simulated on many cranes, section 4.6 of paper D."""
