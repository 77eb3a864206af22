"""Elements, nodes and Gauss points along the beam."""
