"""Result records of the diagnosis, which print and serialize themselves."""
