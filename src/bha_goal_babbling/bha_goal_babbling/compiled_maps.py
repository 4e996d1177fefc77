"""`LocalLinearMaps` in machine code, with near maps only.

The formulas are those of `local_linear_map`, the reference. The one difference is the cut-off: a
map whose responsibility is below `cutoff` times the largest is left out of g(x), of its slope and
of the gradient step. With the cut-off at 0 all maps count, as in the reference; with 1e-3 a point
costs the same however many maps there are.
"""

import math

import numpy as np

from bha_goal_babbling import compiled_kernels as kernels
from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.compiled_kernels import IntArray
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.local_linear_map import LocalLinearMaps
from bha_goal_babbling.saved_state import SavedState

CUTOFF = 1e-3
"""Share of the largest responsibility below which a map does not count."""

_FIRST_CAPACITIES = (16, 64, 32)  # maps, cells, maps in a list: they double when full
_MOST_DIMENSIONS = 3  # of the grid: a block has (2 * radius + 1)^n cells


class CompiledMaps:
    """Local linear maps with a gradient step; an `InverseModel`.

    Parameters
    ----------
    distance : float
        Reach d of a map, in the unit of outcomes. A new map is made where the nearest is farther.
    learning_rate : float
        Step eta of the gradient.
    outcome : array
        Centre of the first map, shape (n,).
    action : array
        Value of the first map, shape (m,): the model is this constant at first.
    cutoff : float
        Share of the largest responsibility below which a map does not count, in 0 to 1 (left
        out). With more than three dimensions of outcomes it saves no search, only sums.
    """

    kind = LocalLinearMaps.kind

    def __init__(
        self,
        distance: float,
        learning_rate: float,
        outcome: FloatArray,
        action: FloatArray,
        cutoff: float = CUTOFF,
    ) -> None:
        if not (distance > 0 and learning_rate > 0 and 0 <= cutoff < 1):
            raise InvalidConfigError(
                "distance and learning_rate must be above 0 and cutoff 0 or above and below 1, "
                f"got {distance}, {learning_rate} and {cutoff}"
            )
        n, m = outcome.size, action.size
        drop = -math.log(cutoff) if cutoff > 0 else math.inf
        # Far enough for every map that counts at a point at most d away from the nearest map.
        radius = math.ceil(math.sqrt(1.0 + drop)) if cutoff > 0 and n <= _MOST_DIMENSIONS else 0
        self.arrays = _empty(
            (float(distance), float(learning_rate), drop, radius), (n, m), _FIRST_CAPACITIES
        )
        """The maps as the machine code takes them; other arrays after each call of a method."""
        self.make_room()
        self._add(outcome, np.vstack([action, np.zeros((n, m))]))

    @property
    def count(self) -> int:
        """Number K of maps."""
        return int(self.arrays.counts[0])

    @property
    def centers(self) -> FloatArray:
        """Centres p_k, shape (K, n), a copy."""
        return self.arrays.centers[: self.count].copy()

    def predict(self, outcome: FloatArray) -> FloatArray:
        """Return g at one outcome, shape (n,), as an action, shape (m,)."""
        action: FloatArray = self.predict_many(outcome[np.newaxis])[0]
        return action

    def predict_many(self, outcomes: FloatArray) -> FloatArray:
        """Return g at many outcomes, shape (N, n), as actions, shape (N, m)."""
        actions = np.empty((len(outcomes), self.arrays.parameters.shape[2]))
        kernels.predict_many(self.arrays, np.ascontiguousarray(outcomes), actions)
        return actions

    def slope(self, outcome: FloatArray) -> FloatArray:
        """Return the derivative dg/dx at one outcome, shape (n,), as shape (m, n)."""
        slope = np.empty(self.arrays.parameters.shape[1:])[1:]
        count, _ = kernels.weigh(self.arrays, outcome)
        kernels.scaled_slope(self.arrays, outcome, count, slope)
        return slope.T / self.arrays.distance

    def insert(self, outcome: FloatArray) -> None:
        """Add a map at an outcome, shape (n,), that leaves g and dg/dx there as they were."""
        self.make_room()
        count, _ = kernels.weigh(self.arrays, outcome)
        kernels.insert(self.arrays, outcome, count)

    def learn(self, outcome: FloatArray, action: FloatArray, weight: float) -> None:
        """Insert a map if the outcome lies beyond all others, then take one gradient step.

        Parameters
        ----------
        outcome : array
            What was observed, shape (n,).
        action : array
            What was executed and measured, shape (m,).
        weight : float
            Weight w of the example.
        """
        self.make_room()
        kernels.learn(self.arrays, outcome, action, float(weight))

    def state(self) -> SavedState:
        """Return everything that `restore` needs; also what `LocalLinearMaps` is restored from."""
        arrays = {
            "centers": self.centers,
            "parameters": self.arrays.parameters[: self.count].copy(),
        }
        settings = {"distance": self.arrays.distance, "learning_rate": self.arrays.rate}
        return SavedState(arrays, settings)

    @classmethod
    def restore(cls, state: SavedState, cutoff: float = CUTOFF) -> "CompiledMaps":
        """Return the maps whose snapshot this is, of either kind."""
        # The reference checks that everything fits together.
        LocalLinearMaps.restore(state)
        centers, parameters = state.arrays["centers"], state.arrays["parameters"]
        maps = cls(
            state.settings["distance"],
            state.settings["learning_rate"],
            centers[0],
            parameters[0, 0],
            cutoff,
        )
        maps.arrays.parameters[0] = parameters[0]
        for center, rows in zip(centers[1:], parameters[1:], strict=True):
            maps.make_room()
            maps._add(center, rows)
        return maps

    def make_room(self) -> None:
        """See to it that one more map fits in: machine code cannot enlarge the arrays."""
        while not kernels.has_room(self.arrays):
            old = self.arrays
            n, m = old.centers.shape[1], old.parameters.shape[2]
            block = (2 * old.radius + 1) ** n
            known, cells, longest = old.counts.tolist()
            grow_maps = known == len(old.centers)
            grow_cells = cells + block > len(old.near_counts)
            grow_lists = longest == old.near.shape[1]
            capacities = (
                len(old.centers) << grow_maps,
                max(len(old.near_counts), block) << grow_cells,
                old.near.shape[1] << grow_lists,
            )
            self.arrays = _empty((old.distance, old.rate, old.drop, old.radius), (n, m), capacities)
            order = (
                _by_place(old.centers[:known], 3.0 * old.distance) if block > 1 else range(known)
            )
            for k in order:
                self._add(old.centers[k], old.parameters[k])

    def _add(self, center: FloatArray, parameters: FloatArray) -> None:
        new = self.count
        self.arrays.centers[new] = center
        self.arrays.parameters[new] = parameters
        self.arrays.counts[0] += 1
        kernels.register(self.arrays, new)


def _by_place(centers: FloatArray, width: float) -> IntArray:
    """Return the order of maps along strips of the space of outcomes, shape (K,).

    Neighbours then lie together in memory too, which counts when maps fill more than the caches.

    Parameters
    ----------
    centers : Centres of the maps, shape (K, n).
    width : Width of a strip.
    """
    strips = np.floor(centers[:, :-1] / width)
    order: IntArray = np.lexsort([centers[:, -1], *strips.T[::-1]])
    return order


def _empty(
    settings: tuple[float, float, float, int],
    sizes: tuple[int, int],
    capacities: tuple[int, int, int],
) -> kernels.Maps:
    """Return no maps, with room.

    Parameters
    ----------
    settings : Distance, learning rate, drop and radius, as in `kernels.Maps`.
    sizes : Numbers n and m of coordinates.
    capacities : Room for maps, for cells, and for maps in the list of a cell.
    """
    (n, m), (maps, cells, lists) = sizes, capacities
    slots = 1 << (2 * cells - 1).bit_length()  # At most half full: a search ends soon.
    return kernels.Maps(
        *settings,
        counts=np.zeros(3, np.int64),
        centers=np.zeros((maps, n)),
        parameters=np.zeros((maps, 1 + n, m)),
        coordinates=np.zeros((slots, n), np.int64),
        slots=np.full(slots, -1, np.int32),
        near=np.zeros((cells, lists), np.int32),
        near_counts=np.zeros(cells, np.int64),
        squared=np.zeros(maps),
        chosen=np.zeros(maps, np.int64),
        features=np.zeros((maps, 1 + n)),
        cell=np.zeros(n, np.int64),
        mean=np.zeros(n),
        residual=np.zeros(m),
    )
