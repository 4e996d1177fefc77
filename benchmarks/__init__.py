"""Measurements behind the figures in the documentation, by rooms.

- `engine`: what a table is, and how it is made, stored, resumed and written
- `arm`: the tables on planar arms and on linear problems, and what they share
- `trunk`: the tables on the simulated trunk, and what they share
- `methods`: the methods that a comparison needs, behind one interface
- `speed`: how fast the learner is
- `scripts`: measurements with a command of their own, outside the tables

`tables` knows the tables of all rooms by their names; `./bha paper` makes them.
"""
