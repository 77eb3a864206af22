"""Results of the diagnosis: frozen records that print and serialize themselves."""
