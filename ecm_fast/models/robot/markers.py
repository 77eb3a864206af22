"""Poses of markers: points fixed to sections of the body, or to the head plate."""

import numpy as np
from numpy.typing import NDArray

from ...kernels.general.newton import solve
from ...kernels.layout import N_OUT, O_THETA, UNSTABLE
from ...kernels.prepare import prepare
from ...mechanism.body import Marker
from ...mechanism.mechanism import Mechanism
from ...mechanism.mesh.discretization import Discretization
from ...mechanism.vector import pack
from ..body import breaks, divide, on_mesh
from ..refinement import work_arrays
from .tendons import by_length, without_given

__all__ = ["marker_poses", "moved_by_offset"]

Array = NDArray[np.float64]


def moved_by_offset(marker: Marker, pose: Array) -> Array:
    """Return the pose of a marker, (3,), from that of the section it is fixed to."""
    s, c = np.sin(pose[2]), np.cos(pose[2])
    x = pose[0] + marker.offset_x * c + marker.offset_z * s
    return np.array([x, pose[1] + marker.offset_z * c - marker.offset_x * s, pose[2] + marker.angle])


def marker_poses(mechanism: Mechanism, mesh: Discretization, par: Array, loads: Array, wanted: Array | None) -> Array:
    """Return the poses of a mechanism's markers, (n, 3) [m, m, rad].

    Solved again on elements that are no longer than those of `mesh`, and end at the markers: there an angle and a place
    are exact to the order of the tip's.

    mesh, par : on which a case was solved, and its parameter vector without markers
    loads : (N_LOADS,) of the equilibrium; wanted : see `solution.NodalSolution`
    """
    ends = np.interp(np.cumsum([0.0, *mesh.shares]), np.linspace(0.0, 1.0, breaks(par).size), breaks(par))
    vector = pack(mechanism)
    finer = Discretization.from_elements(divide(vector, np.diff(ends)), mesh.order, mesh.gauss)
    if wanted is not None:
        found = by_length(finer, vector, without_given(loads, wanted), wanted)
        status, q, turned = found.status, found.q, found.q[-1]
    else:
        stations, tip, q_rest, q, work = work_arrays(finer)
        out = np.empty(N_OUT)
        prepare(vector, finer.mesh, finer.nodes, stations, tip, q_rest)
        status, turned = solve(finer.tables, stations, tip, q_rest, loads, q, work, out), out[O_THETA]
    if status > UNSTABLE:
        return np.full((len(mechanism.markers), 3), np.nan)
    nodes, poses = q.reshape(-1, 3), []
    for marker in mechanism.markers:
        if marker.on_head:
            poses.append(moved_by_offset(marker, np.array([*nodes[-1, :2], turned])))
        else:
            node = int(np.argmin(np.abs(finer.nodes - on_mesh(vector, marker.place))))
            poses.append(moved_by_offset(marker, nodes[node]))
    return np.array(poses).reshape(-1, 3)
