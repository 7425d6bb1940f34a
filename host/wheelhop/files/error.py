"""What a user can mend."""

LONGEST = 2000  # characters that a terminal shows without losing the beginning


class InputError(ValueError):
    """A mistake of the user, or trouble in the world; ``str(error)`` is the one line that says
    where, what, and what to do. Each package has its own kind."""

    def __init__(self, line: str) -> None:
        # What is quoted from a tool or a file may hold line ends or terminal codes.
        if len(line) > LONGEST:
            line = f"{line[: LONGEST // 2]} … {line[-LONGEST // 2 :]}"
        super().__init__("".join(char if char.isprintable() else "?" for char in line))
