"""Arithmetic on flat float64 arrays, compiled: no objects, no units, no strings, no exceptions, no allocation.

Read in this order: `layout` (what the arrays hold), `prepare` (parameter vector to solver constants), `section`,
`element`, `tip` (forces and tangents), `front` (factor and solve), `newton` (equilibrium), `batch` (many of them);
`condensed` (the fast path) and `polynomial` (the fitted models) stand beside them, `se2` and `strain` in the place of
`element` where `mechanism.mesh.families` puts them.
The formulas themselves are stated once, in `ecm_fast.models.reference`, under the same names.
"""
