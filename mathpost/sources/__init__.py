"""The methods of single source documents.

`recipes` holds the two ZXZ recipes of source 000, `csy_transform` the transform of I++ DME (source 003), `yu_dan`
the rules and splines of the paper by Yu Dan et al. (source 002).
"""
