"""Faults of what reaches a node from outside, each a sentence for its user."""


class MessageError(ValueError):
    """A message that cannot be used; says what is wrong with it and what would be right."""


class ParameterError(ValueError):
    """A parameter that a node cannot start with; says what would be right."""
