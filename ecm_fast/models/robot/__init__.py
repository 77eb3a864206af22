"""Parts of models that tendon robots alone need: tendons along the body, markers, their control step."""
