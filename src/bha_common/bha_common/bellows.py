"""The nine bellows: their names, their order, and the numbers a lab knows beforehand."""

from __future__ import annotations

SEGMENTS = 3
CHAMBERS = 3
COUNT = SEGMENTS * CHAMBERS

NAMES: tuple[str, ...] = tuple(
    f"bellows_{segment}_{chamber}"
    for segment in range(1, SEGMENTS + 1)
    for chamber in range(1, CHAMBERS + 1)
)
"""Names of the bellows in the order of every array of shape (9,): base segment first."""

MAX_PRESSURE = 1.3e5
"""Highest gauge pressure that a bellows is driven with [Pa]."""

MIN_LENGTH, MAX_LENGTH = 0.10, 0.40
"""Lengths beyond which a reading or a command cannot be meant [m]; real ranges are narrower."""

MAX_REACH = 2.0
"""Distance from the base beyond which a tip cannot be meant [m]; the trunk ends at about 1 m."""

BASE_FRAME = "bha_base"
"""Frame of every tip and goal: z along the trunk's axis at rest, away from the base."""
