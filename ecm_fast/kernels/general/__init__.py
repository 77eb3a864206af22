"""The general path: Newton iteration on all nodes of any mesh, with load steps."""
