"""All indices of the library on eight robots: do they agree with autograd and with other packages, and what do they cost."""
