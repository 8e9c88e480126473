"""How the crane's networks are trained, and how large they should be, sections 2.4.3 to 2.4.5 of paper D."""
