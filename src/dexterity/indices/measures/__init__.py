"""Measures, one in each file; :mod:`dexterity.indices.registry` finds them by itself.

Examples
--------
>>> from dexterity.indices.measures.isotropy import MEASURE
>>> MEASURE.title
'Isotropy, geometric over arithmetic mean'
"""
