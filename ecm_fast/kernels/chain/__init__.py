"""The chain path: several elements, each condensed, coupled by sweeps along the beam."""
