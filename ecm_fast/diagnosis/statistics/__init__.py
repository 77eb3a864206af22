"""Statistics of the diagnosis: robust noise, evidence, priors, lack of fit."""
