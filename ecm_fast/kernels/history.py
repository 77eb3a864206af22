"""Quantities that a row inherits from the rows before it: friction, memory, drift."""

import numpy as np

from ._jit import kernel

__all__ = ["follow", "tendon_lengths"]

# a tendon that moves less has not moved [m]
STILL = 1e-9


@kernel
def tendon_lengths(pose, attached, pulleys, lengths):
    """Distance from attachment to pulley center of both tendons.

    pose : (n, 3) of the head; attached : (1 or n, 2, 2) attachments in the head's frame, left and right
    pulleys : (1 or n, 2, 2) their centers; lengths : (n, 2)   overwritten
    """
    for i in range(pose.shape[0]):
        own = min(i, attached.shape[0] - 1)
        s, c = np.sin(pose[i, 2]), np.cos(pose[i, 2])
        for side in range(2):
            along, across = attached[own, side, 0], attached[own, side, 1]
            x = pose[i, 0] + along * c + across * s - pulleys[own, side, 0]
            z = pose[i, 1] + across * c - along * s - pulleys[own, side, 1]
            lengths[i, side] = np.sqrt(x * x + z * z)


@kernel
def follow(begins, repeats, held, theta, lengths, rest, angle, time, travel, slider, gap):
    """Follow the record row by row.

    begins, repeats : (n,) whether a row begins a history, and whether it repeats the load of the row before
    held : (n,) time held before reading [s]
    theta, lengths : (n,), (n, 2) tip angle and tendons without memory; rest : (2,) lengths on the straight neck
    angle, time : at which the slider slides [rad], and after which memory fades [s]; real or complex
    travel : (n, 2), slider, gap : (n,)   overwritten; nan rows, which have no equilibrium, pass nothing on
    """
    last_l, last_r, before = rest[0], rest[1], 0.0
    way_l, way_r = 0.0, 0.0
    h, remembered = 0.0 * angle, 0.0 * time
    for i in range(theta.shape[0]):
        if begins[i]:
            last_l, last_r, before, way_l, way_r = rest[0], rest[1], 0.0, 0.0, 0.0
            h, remembered = 0.0 * angle, 0.0 * time
        travel[i, 0], travel[i, 1], slider[i], gap[i] = way_l, way_r, h, 0.0 * time
        if not np.isfinite(theta[i]):
            continue
        if not repeats[i]:
            way_l = np.sign(last_l - lengths[i, 0]) if abs(last_l - lengths[i, 0]) > STILL else way_l
            way_r = np.sign(last_r - lengths[i, 1]) if abs(last_r - lengths[i, 1]) > STILL else way_r
            last_l, last_r = lengths[i, 0], lengths[i, 1]
        h += (theta[i] - before) / angle
        h = 1.0 + 0.0 * angle if h.real > 1.0 else h
        h = -1.0 + 0.0 * angle if h.real < -1.0 else h
        before = theta[i]
        left = (theta[i] - remembered) * np.exp(-held[i] / time)
        remembered = theta[i] - left
        travel[i, 0], travel[i, 1], slider[i], gap[i] = way_l, way_r, h, left
