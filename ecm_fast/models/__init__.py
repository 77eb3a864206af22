"""Models of a mechanism: finite elements, batches, inverse, sensitivities, polynomial."""
