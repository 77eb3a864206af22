"""Frame of all commands: arguments, answers, interrupts, and what a terminal shows."""
