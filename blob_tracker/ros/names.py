"""Names of topics that depend on a light."""


def target_topic(light: str) -> str:
    """Return what the names of a light's topics begin with; the only light has no name."""
    return f'target/{light}' if light else 'target'
