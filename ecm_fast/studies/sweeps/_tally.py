"""Histogram, extremes and sums of one column, in two compiled passes."""

from ...kernels._jit import kernel

__all__ = ["tally"]


@kernel
def tally(values, status, low, per_unit, counts, places, sums):
    """Count and sum the values of the cases whose status is 0.

    values, status : (n,)
    low, per_unit : where the histogram begins, bins by unit of the value
    counts : (bins + 2,)   added to: below, the bins, above
    places : (2,)   overwritten: the rows of the least and the largest value, -1 where there is none
    sums : (5,)   overwritten: how many, mean, sums of the squares, cubes and fourth powers of the distances from it
    """
    n, total, least, most, last = 0, 0.0, 0.0, 0.0, counts.shape[0] - 1
    places[0], places[1] = -1, -1
    for i in range(values.shape[0]):
        if status[i] == 0:
            value = values[i]
            if n == 0 or value < least:
                least, places[0] = value, i
            if n == 0 or value > most:
                most, places[1] = value, i
            n += 1
            total += value
            place = (value - low) * per_unit + 1.0
            counts[int(min(max(place, 0.0), last))] += 1
    mean = total / n if n > 0 else 0.0
    second, third, fourth = 0.0, 0.0, 0.0
    for i in range(values.shape[0]):
        away = values[i] - mean if status[i] == 0 else 0.0
        square = away * away
        second += square
        third += square * away
        fourth += square * square
    sums[0], sums[1], sums[2], sums[3], sums[4] = n, mean, second, third, fourth
