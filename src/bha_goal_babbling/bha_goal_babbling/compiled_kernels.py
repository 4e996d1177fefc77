"""Machine code of the inverse model and of the whole loop of goal babbling.

Everything compiled stands in this file: the cache on disk notices a change in the file of a
compiled function, but not in the files of those it calls. The functions compute what
`LocalLinearMaps` and `GoalBabbler` compute, which are their reference; the classes around them are
in `compiled_maps` and `compiled_babbler`.

Where the time goes is the sum over maps. Maps lie at least d apart, so only few are near a point,
and those whose responsibility is below a cut-off share of the largest are left out. A hash grid of
cells of size d finds the others: for every cell it holds a list of all maps in the block of cells
around it. That list grows when a map comes, which is rare, and is read at every step, which then
costs the same with ten thousand maps as with ten.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import numba
import numpy as np
from numba.np.random._constants import fi_double, ki_double, wi_double
from numba.np.random.generator_core import next_uint64
from numpy.typing import NDArray

from bha_goal_babbling.arrays import FloatArray

IntArray = NDArray[np.int64]
ShortArray = NDArray[np.int32]
Function = TypeVar("Function", bound=Callable[..., Any])

# Sums may be reordered and products fused: differences of 1e-16. Infinities keep their meaning.
_MATH = {"reassoc", "contract", "arcp", "nsz"}

_VECTOR = numba.types.float64[::1]
FORWARD_SIGNATURE = numba.types.void(_VECTOR, _VECTOR)
"""Type of a forward function: (action, shape (m,); filled with the outcome, shape (n,))."""


def inlined(function: Function) -> Function:
    """Compile a function of the inner loop into its callers, and keep their code on disk.

    A call would copy every number of the tuples of arrays. And without numba's run time a function
    cannot allocate, but counts no references to arrays either: counting is atomic. Both would take
    more time than the arithmetic.
    """
    return _compiled(function, _nrt=False, forceinline=True)


def called(function: Function) -> Function:
    """Compile a function of the inner loop that is called now and then, or from Python."""
    return _compiled(function, _nrt=False)


def called_with_run_time(function: Function) -> Function:
    """Compile a function that allocates."""
    return _compiled(function)


def _compiled(function: Function, **options: bool) -> Function:
    compile_ = numba.njit(cache=True, fastmath=_MATH, error_model="numpy", **options)
    result: Function = compile_(function)
    return result


@inlined
def _copy(source: FloatArray, target: FloatArray) -> None:
    """Copy an array over the beginning of another; numba's own way may allocate."""
    for i in range(len(source)):
        target[i] = source[i]


class Maps(NamedTuple):
    """Local linear maps, the grid that finds them, and room to work in.

    Attributes
    ----------
    distance, rate : Reach d [outcome unit] and learning rate eta [-].
    drop : A map counts while |z_k|^2 is at most the smallest one plus this; infinity for all.
    radius : Cells on each side of a cell in whose block near maps are looked for; 0: no grid.
    counts : Numbers of maps, of cells, and of maps in the longest list, shape (3,).
    centers : Centres p_k [outcome unit], shape (capacity, n).
    parameters : v_k and the columns of M_k [action unit], shape (capacity, 1 + n, m).
    coordinates : Integer coordinates of the cell in each slot of the hash table, shape (slots, n).
    slots : Index of that cell, or -1 where the slot is free, shape (slots,).
    near : Maps in the block around each cell, shape (cells, longest list).
    near_counts : How many they are, shape (cells,).
    squared, chosen, features : Room for |z_k|^2, for the maps that count, and for their
        h_k [1, z_k]; shapes (capacity,), (capacity,) and (capacity, 1 + n).
    cell, mean, residual : Room for the coordinates of a cell, a mean of z_k, and q - g(x); shapes
        (n,), (n,) and (m,).
    """

    distance: float
    rate: float
    drop: float
    radius: int
    counts: IntArray
    centers: FloatArray
    parameters: FloatArray
    coordinates: IntArray
    slots: ShortArray
    near: ShortArray
    near_counts: IntArray
    squared: FloatArray
    chosen: IntArray
    features: FloatArray
    cell: IntArray
    mean: FloatArray
    residual: FloatArray


@inlined
def _first_slot(maps: Maps, cell: IntArray) -> int:
    """Return the slot of the hash table at which the search for a cell begins."""
    key = np.uint64(0)
    for i in range(len(cell)):
        # Odd constant of Fibonacci hashing, 2^64 over the golden ratio.
        key = (key ^ np.uint64(cell[i])) * np.uint64(0x9E3779B97F4A7C15)
        key ^= key >> np.uint64(29)
    return int(np.int64(key & np.uint64(len(maps.slots) - 1)))


@inlined
def _find_slot(maps: Maps, cell: IntArray) -> int:
    """Return the slot that holds a cell, or else the free one where it belongs."""
    slot = _first_slot(maps, cell)
    while maps.slots[slot] >= 0:
        same = True
        for i in range(len(cell)):
            same = same and maps.coordinates[slot, i] == cell[i]
        if same:
            break
        slot = (slot + 1) & (len(maps.slots) - 1)
    return slot


@inlined
def _cell_at(maps: Maps, outcome: FloatArray) -> int:
    """Return the index of the cell around an outcome, -1 if no map is near."""
    cell = maps.cell
    for i in range(len(outcome)):
        cell[i] = np.int64(math.floor(outcome[i] / maps.distance))
    return int(maps.slots[_find_slot(maps, cell)])


@called
def register(maps: Maps, index: int) -> None:
    """Enter a map in the lists of all cells in the block around it."""
    if maps.radius == 0:
        return
    n = maps.centers.shape[1]
    side = 2 * maps.radius + 1
    cell = maps.cell
    for block in range(side**n):
        rest = block
        for i in range(n):
            middle = np.int64(math.floor(maps.centers[index, i] / maps.distance))
            cell[i] = middle + rest % side - maps.radius
            rest //= side
        slot = _find_slot(maps, cell)
        if maps.slots[slot] < 0:
            for i in range(n):
                maps.coordinates[slot, i] = cell[i]
            maps.slots[slot] = maps.counts[1]
            maps.counts[1] += 1
        entry = maps.slots[slot]
        maps.near[entry, maps.near_counts[entry]] = index
        maps.near_counts[entry] += 1
        maps.counts[2] = max(maps.counts[2], maps.near_counts[entry])


@inlined
def has_room(maps: Maps) -> bool:
    """Return whether one more map fits in everywhere."""
    if maps.counts[0] == len(maps.centers):
        return False
    if maps.radius == 0:
        return True
    cells = maps.counts[1] + (2 * maps.radius + 1) ** maps.centers.shape[1]
    return cells <= len(maps.near_counts) and bool(maps.counts[2] < maps.near.shape[1])


@inlined
def _measure(maps: Maps, outcome: FloatArray, cell: int) -> float:
    """Fill |z_k|^2 of a cell's maps, or of all for cell -1, and return the smallest."""
    nearest = np.inf
    n = len(outcome)
    total = maps.counts[0] if cell < 0 else maps.near_counts[cell]
    scale = 1.0 / maps.distance
    for i in range(total):
        k = np.uint64(i if cell < 0 else maps.near[cell, i])
        z = (outcome[0] - maps.centers[k, 0]) * scale
        squared = z * z
        for j in range(1, n):
            z = (outcome[j] - maps.centers[k, j]) * scale
            squared += z * z
        maps.squared[i] = squared
        nearest = min(nearest, squared)
    return nearest


@inlined
def exponentials(values: FloatArray, count: int) -> None:
    """Replace the first values, which are in -8 to 0, by their exponentials, to 1e-14.

    exp(x) = exp(x/16)^16, the inner one by its Taylor polynomial. Without branches and tables the
    compiler computes several at once, in a fraction of the time of math.exp.
    """
    for i in range(count):
        x = values[i] / 16.0
        y = 1.0 + x / 14.0
        for order in (13.0, 12.0, 11.0, 10.0, 9.0, 8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0):
            y = 1.0 + x / order * y
        y *= y
        y *= y
        y *= y
        values[i] = y * y


@inlined
def weigh(maps: Maps, outcome: FloatArray) -> tuple[int, float]:
    """Fill `chosen` and `features` with the maps that count at an outcome.

    Parameters
    ----------
    maps : Maps
        The maps.
    outcome : array
        Where, shape (n,).

    Returns
    -------
    How many maps count, and the smallest |z_k|^2.
    """
    n = len(outcome)
    cell = -1
    nearest = np.inf
    if maps.radius > 0:
        cell = _cell_at(maps, outcome)
        if cell >= 0:
            nearest = _measure(maps, outcome, cell)
            # A map outside of the block has |z|^2 above radius^2. One that counts may be there.
            if nearest + maps.drop > maps.radius * maps.radius:
                cell = -1
    if cell < 0:
        nearest = _measure(maps, outcome, cell)
    total = maps.counts[0] if cell < 0 else maps.near_counts[cell]
    count = 0
    for i in range(total):
        # Without the subtraction every exponential is 0 far from all maps, and h is 0 / 0.
        maps.chosen[count] = i if cell < 0 else maps.near[cell, i]
        exponent = nearest - maps.squared[i]
        maps.squared[count] = exponent
        count += exponent >= -maps.drop
    if maps.drop <= 8.0:
        exponentials(maps.squared, count)
    else:
        for i in range(count):
            maps.squared[i] = math.exp(maps.squared[i])
    total_weight = 0.0
    for i in range(count):
        total_weight += maps.squared[i]
    scale = 1.0 / total_weight
    for i in range(count):
        h = maps.squared[i] * scale
        maps.features[i, 0] = h
        for j in range(n):
            z = (outcome[j] - maps.centers[np.uint64(maps.chosen[i]), j]) / maps.distance
            maps.features[i, 1 + j] = h * z
    return count, nearest


@inlined
def blend(maps: Maps, count: int, action: FloatArray) -> None:
    """Fill g(x) = sum_k h_k [1, z_k] parameters_k, shape (m,), after `weigh`."""
    rows, m = maps.parameters.shape[1], maps.parameters.shape[2]
    for j in range(m):
        action[j] = 0.0
    for i in range(count):
        value = maps.parameters[np.uint64(maps.chosen[i])]
        if rows == 3:
            # n = 2, the usual case: one pass over the action for all rows.
            a, b, c = maps.features[i, 0], maps.features[i, 1], maps.features[i, 2]
            for j in range(m):
                action[j] += a * value[0, j] + b * value[1, j] + c * value[2, j]
        else:
            for row in range(rows):
                a = maps.features[i, row]
                for j in range(m):
                    action[j] += a * value[row, j]


@called
def scaled_slope(maps: Maps, outcome: FloatArray, count: int, slope: FloatArray) -> None:
    """Fill d times dg/dx, transposed, shape (n, m), after `weigh`.

    dh_k/dx = 2 h_k (sum_j h_j z_j - z_k) / d adds to the slopes of the maps.
    """
    n, m = maps.centers.shape[1], maps.parameters.shape[2]
    slope[:] = 0.0
    mean = maps.mean
    mean[:] = 0.0
    for i in range(count):
        for axis in range(n):
            mean[axis] += maps.features[i, 1 + axis]
    for i in range(count):
        k = maps.chosen[i]
        h = maps.features[i, 0]
        for j in range(m):
            local = h * maps.parameters[k, 0, j]
            for axis in range(n):
                local += maps.features[i, 1 + axis] * maps.parameters[k, 1 + axis, j]
            for axis in range(n):
                z = (outcome[axis] - maps.centers[k, axis]) / maps.distance
                slope[axis, j] += h * maps.parameters[k, 1 + axis, j]
                slope[axis, j] += 2.0 * (mean[axis] - z) * local


@called
def insert(maps: Maps, outcome: FloatArray, count: int) -> None:
    """Add a map at an outcome that leaves g and dg/dx there as they were, after `weigh`."""
    new = maps.counts[0]
    blend(maps, count, maps.parameters[new, 0])
    scaled_slope(maps, outcome, count, maps.parameters[new, 1:])
    _copy(outcome, maps.centers[new])
    maps.counts[0] += 1
    register(maps, new)


@inlined
def learn(
    maps: Maps,
    outcome: FloatArray,
    action: FloatArray,
    weight: float,
) -> None:
    """Insert a map if the outcome lies beyond all others, then take one gradient step.

    Parameters
    ----------
    maps : Maps
        The maps.
    outcome, action : array
        The example, shapes (n,) and (m,).
    weight : float
        Weight w of the example.
    """
    count, nearest = weigh(maps, outcome)
    if nearest > 1.0:
        insert(maps, outcome, count)
        count, nearest = weigh(maps, outcome)
    residual = maps.residual
    blend(maps, count, residual)
    rows, m = maps.parameters.shape[1], maps.parameters.shape[2]
    gain = maps.rate * weight
    for j in range(m):
        residual[j] = gain * (action[j] - residual[j])
    for i in range(count):
        value = maps.parameters[np.uint64(maps.chosen[i])]
        if rows == 3:
            a, b, c = maps.features[i, 0], maps.features[i, 1], maps.features[i, 2]
            for j in range(m):
                value[0, j] += a * residual[j]
                value[1, j] += b * residual[j]
                value[2, j] += c * residual[j]
        else:
            for row in range(rows):
                a = maps.features[i, row]
                for j in range(m):
                    value[row, j] += a * residual[j]


@called
def predict_many(maps: Maps, outcomes: FloatArray, actions: FloatArray) -> None:
    """Fill g at many outcomes, shape (N, n), as actions, shape (N, m)."""
    for i in range(len(outcomes)):
        count, _ = weigh(maps, outcomes[i])
        blend(maps, count, actions[i])


class Task(NamedTuple):
    """What does not change while a learner babbles: its settings, goals, home and limits.

    Attributes
    ----------
    goals : The goal set [outcome unit], shape (G, n); none (0, n) for direction sampling.
    direction_step : Distance eps between targets of direction sampling [outcome unit].
    path_steps, home_probability : Steps L of a movement, and the chance that it goes home.
    home_action, home_outcome : Home, shapes (m,) and (n,).
    low, high : Limits of actions, shape (m,).
    noise_origin : Origin of the noise's x* [outcome unit], shape (n,).
    noise_step, noise_keep : Step sd of the noise's walk [action unit], and its shrinkage [-].
    action_scale, outcome_scale : Sizes of actions and outcomes.
    action_resolution, outcome_resolution : Shortest steps that count, in scaled units.
    use_direction, use_efficiency : Whether w_dir and w_eff weight at all.
    relative, limit : Whether w_eff is divided by its running mean, and its largest value.
    mean_rate, mean_head_start : Constants of that mean.
    """

    goals: FloatArray
    direction_step: float
    path_steps: int
    home_probability: float
    home_action: FloatArray
    home_outcome: FloatArray
    low: FloatArray
    high: FloatArray
    noise_origin: FloatArray
    noise_step: float
    noise_keep: float
    action_scale: float
    outcome_scale: float
    action_resolution: float
    outcome_resolution: float
    use_direction: bool
    use_efficiency: bool
    relative: bool
    limit: float
    mean_rate: float
    mean_head_start: int


class State(NamedTuple):
    """What changes: where the learner is.

    Attributes
    ----------
    action, outcome : The last q and x, shapes (m,) and (n,).
    previous : The last target [outcome unit], shape (n,).
    target : The present target, shape (n,).
    start : Where the present movement began, an outcome, or an action on the way home;
        shape (max(m, n),).
    advance : Step of direction sampling, shape (n,).
    noise : c_t and the columns of A_t [action unit], shape (1 + n, m).
    mean : Running mean of w_eff, shape (1,).
    over, going_home, step, movements, goal, weighted : Whether the movement is over, whether it
        goes home, its steps made, the number of movements, the last goal (-1 for none), and the
        number of efficiencies in the mean; shape (6,).
    new_action, scaled_action, new_outcome, scaled_outcome : Room to work in, shapes (m,), (m,),
        (n,) and (n,).
    """

    action: FloatArray
    outcome: FloatArray
    previous: FloatArray
    target: FloatArray
    start: FloatArray
    advance: FloatArray
    noise: FloatArray
    mean: FloatArray
    numbers: IntArray
    new_action: FloatArray
    scaled_action: FloatArray
    new_outcome: FloatArray
    scaled_outcome: FloatArray


OVER, GOING_HOME, STEP, MOVEMENTS, GOAL, WEIGHTED = range(6)


@inlined
def draw_normal(rng: np.random.Generator) -> float:
    """Return a standard normal number, the one that `rng.standard_normal()` would.

    The algorithm is numpy's: the ziggurat of Marsaglia and Tsang with 256 layers. numba's own
    version of it is a call with an unpredictable branch for the sign, and takes twice the time.
    """
    drawn = next_uint64(rng.bit_generator)
    layer = drawn & np.uint64(0xFF)
    sign = 1.0 - 2.0 * np.float64(np.int64((drawn >> np.uint64(8)) & np.uint64(1)))
    place = (drawn >> np.uint64(9)) & np.uint64(0x000FFFFFFFFFFFFF)
    normal = np.float64(np.int64(place)) * wi_double[layer] * sign
    if place < ki_double[layer]:
        return float(normal)
    return _normal_at_an_edge(rng, normal, place, layer)


@inlined
def walk(rng: np.random.Generator, step: float, keep: float, noise: FloatArray) -> None:
    """Take one step of the noise's random walk, shape (1 + n, m), as `ExplorationNoise` does."""
    rows, columns = noise.shape
    for row in range(rows):
        for column in range(columns):
            noise[row, column] = keep * (noise[row, column] + step * draw_normal(rng))


@called
def _normal_at_an_edge(rng: np.random.Generator, normal: float, place: int, layer: int) -> float:
    """Return the normal that comes of a draw outside of a layer's inner rectangle; one in 80."""
    if layer == 0:
        # The tail beyond the last layer, by Marsaglia's method.
        edge = 3.6541528853610088
        while True:
            far = -math.log1p(-rng.random()) / edge
            if -2.0 * math.log1p(-rng.random()) > far * far:
                break
        return -(edge + far) if (place >> np.uint64(8)) & np.uint64(1) else edge + far
    density = fi_double[layer] + (fi_double[layer - np.uint64(1)] - fi_double[layer]) * rng.random()
    if density < math.exp(-0.5 * normal * normal):
        return normal
    return rng.standard_normal()


@called_with_run_time
def _begin(task: Task, state: State, rng: np.random.Generator) -> None:
    """Start the next movement, as `Movements.prepare` does."""
    numbers = state.numbers
    numbers[OVER] = 0
    numbers[STEP] = 0
    if numbers[GOING_HOME] == 0 and rng.random() < task.home_probability:
        numbers[GOING_HOME] = 1
        _copy(state.action, state.start)
        _copy(task.home_outcome, state.target)
        return
    numbers[GOING_HOME] = 0
    n = len(state.outcome)
    if len(task.goals) == 0:
        length = 0.0
        while length < 1e-9:
            length = 0.0
            for i in range(n):
                state.advance[i] = rng.standard_normal()
                length += state.advance[i] ** 2
            length = math.sqrt(length)
        for i in range(n):
            state.advance[i] *= task.direction_step / length
        _copy(state.outcome, state.previous)
        _copy(state.outcome, state.start)
        return
    if numbers[GOAL] < 0:
        numbers[GOAL] = rng.integers(0, len(task.goals))
    else:
        index = rng.integers(0, len(task.goals) - 1)
        numbers[GOAL] = index if index < numbers[GOAL] else index + 1
    _copy(state.previous, state.start)


@inlined
def _aim(task: Task, state: State) -> None:
    """Fill the target of the present step of a movement that does not go home."""
    n = len(state.outcome)
    step = state.numbers[STEP] + 1
    if len(task.goals) == 0:
        for i in range(n):
            state.target[i] = state.advance[i] + (state.start[i] if step == 1 else state.target[i])
    elif step == task.path_steps:
        _copy(task.goals[state.numbers[GOAL]], state.target)
    else:
        share = step / task.path_steps
        goal = task.goals[state.numbers[GOAL]]
        for i in range(n):
            state.target[i] = state.start[i] + share * (goal[i] - state.start[i])


@inlined
def _weight(task: Task, state: State, action: FloatArray, outcome: FloatArray) -> float:
    """Return w = w_dir w_eff, as `SampleWeights` does."""
    action_length = 0.0
    for j in range(len(action)):
        action_length += (action[j] - state.action[j]) ** 2
    action_length = math.sqrt(action_length) / task.action_scale
    outcome_length, target_length, inner = 0.0, 0.0, 0.0
    for i in range(len(outcome)):
        outcome_step = (outcome[i] - state.outcome[i]) / task.outcome_scale
        target_step = (state.target[i] - state.previous[i]) / task.outcome_scale
        outcome_length += outcome_step * outcome_step
        target_length += target_step * target_step
        inner += outcome_step * target_step
    outcome_length, target_length = math.sqrt(outcome_length), math.sqrt(target_length)
    efficiency = 0.0
    if action_length > task.action_resolution:
        efficiency = outcome_length / action_length
    if not task.use_efficiency:
        efficiency = 1.0 if action_length > task.action_resolution else 0.0
    elif task.relative and efficiency > 0.0:
        rate = max(task.mean_rate, 1.0 / (state.numbers[WEIGHTED] + task.mean_head_start))
        state.numbers[WEIGHTED] += 1
        state.mean[0] += rate * (efficiency - state.mean[0])
        efficiency /= state.mean[0]
    if task.use_efficiency:
        efficiency = min(efficiency, task.limit)
    if state.numbers[GOING_HOME] == 1 or not task.use_direction:
        return efficiency
    direction = 0.5
    if target_length > 0.0 and outcome_length > task.outcome_resolution:
        cosine = inner / target_length / outcome_length
        direction = 0.5 * (1.0 + min(1.0, max(-1.0, cosine)))
    return direction * efficiency


@inlined
def _ask(maps: Maps, task: Task, state: State, rng: np.random.Generator) -> None:
    """Fill the next action, as `GoalBabbler.ask` does."""
    n, m = len(state.outcome), len(state.action)
    action = state.new_action
    step = state.numbers[STEP] + 1
    if state.numbers[GOING_HOME] == 1:
        share = step / task.path_steps
        for j in range(m):
            action[j] = state.start[j] + share * (task.home_action[j] - state.start[j])
        if step == task.path_steps:
            _copy(task.home_action, action)
    else:
        _aim(task, state)
        walk(rng, task.noise_step, task.noise_keep, state.noise)
        for i in range(n):
            state.scaled_outcome[i] = state.target[i] / task.outcome_scale
        count, _ = weigh(maps, state.scaled_outcome)
        blend(maps, count, action)
        for j in range(m):
            action[j] = task.action_scale * action[j] + state.noise[0, j]
        for i in range(n):
            place = (state.target[i] - task.noise_origin[i]) / task.outcome_scale
            for j in range(m):
                action[j] += place * state.noise[1 + i, j]
    for j in range(m):
        action[j] = min(max(action[j], task.low[j]), task.high[j])


@inlined
def _tell(maps: Maps, task: Task, state: State) -> None:
    """Learn what came of the action, and go on, as `GoalBabbler.tell` does."""
    n, m = len(state.outcome), len(state.action)
    action, outcome, numbers = state.new_action, state.new_outcome, state.numbers
    weight = _weight(task, state, action, outcome)
    if weight > 0.0:
        for j in range(m):
            state.scaled_action[j] = action[j] / task.action_scale
        for i in range(n):
            state.scaled_outcome[i] = outcome[i] / task.outcome_scale
        learn(maps, state.scaled_outcome, state.scaled_action, weight)
    numbers[STEP] += 1
    if numbers[GOING_HOME] == 1 or len(task.goals) > 0:
        over = numbers[STEP] == task.path_steps
    else:
        inner = 0.0
        for i in range(n):
            inner += state.advance[i] * (outcome[i] - state.outcome[i])
        over = inner < 0.0
    numbers[OVER] = over
    numbers[MOVEMENTS] += over
    _copy(state.target, state.previous)
    _copy(action, state.action)
    _copy(outcome, state.outcome)


@called
def _move(
    maps: Maps,
    task: Task,
    state: State,
    forward: Callable[[FloatArray, FloatArray], None],
    rng: np.random.Generator,
    visited: FloatArray,
    first: int,
) -> int:
    """Make the steps of a movement from sample `first` on; return the number of the next."""
    for sample in range(first, len(visited)):
        if not has_room(maps):
            return sample
        _ask(maps, task, state, rng)
        forward(state.new_action, state.new_outcome)
        _tell(maps, task, state)
        for i in range(len(state.outcome)):
            visited[sample, i] = state.outcome[i]
        if state.numbers[OVER] == 1:
            return sample + 1
    return len(visited)


@called_with_run_time
def babble(
    maps: Maps,
    task: Task,
    state: State,
    forward: Callable[[FloatArray, FloatArray], None],
    rng: np.random.Generator,
    movements: int,
    visited: FloatArray,
) -> int:
    """Babble until `visited` is full, some movements are finished, or there is no room for a map.

    Parameters
    ----------
    maps, task, state : Maps, Task, State
        The learner.
    forward : callable
        The robot, of `FORWARD_SIGNATURE`.
    rng : numpy.random.Generator
        Source of all randomness.
    movements : int
        Number of finished movements at which it ends.
    visited : array
        Filled with the outcomes, shape (samples, n).

    Returns
    -------
    Number of samples made.
    """
    samples = 0
    while samples < len(visited) and state.numbers[MOVEMENTS] < movements and has_room(maps):
        if state.numbers[OVER] == 1:
            _begin(task, state, rng)
        samples = _move(maps, task, state, forward, rng, visited, samples)
    return samples
