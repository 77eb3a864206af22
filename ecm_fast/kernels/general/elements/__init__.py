"""Elements of every family: their residuals and tangents."""
