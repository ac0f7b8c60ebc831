"""One family of exceptions; each knows the exit status the command line gives it."""

__all__ = [
    "GenArtError",
    "UsageError",
    "PresetError",
    "MemoryRefused",
    "OutputError",
    "EncoderError",
    "InstallationError",
    "DivergedError",
    "AdviceWarning",
]


class GenArtError(Exception):
    """The base of every error this package raises on purpose: a sentence for a person, no traceback needed."""

    exit_code = 1


class UsageError(GenArtError, ValueError):
    """Wrong usage: an option, an argument or a call that cannot be meant."""

    exit_code = 2


class PresetError(GenArtError, ValueError):
    """A bad preset. The message holds one `file:line:column: path: problem` block per problem."""

    exit_code = 3


class MemoryRefused(GenArtError):
    """Refused before it starts, for want of memory or disk; the message names the figure."""

    exit_code = 4


class OutputError(GenArtError, OSError):
    """Reading or writing a file failed: disk full, no permission, already there."""

    exit_code = 5


class EncoderError(GenArtError):
    """The video encoder failed; the message names what was kept."""

    exit_code = 6


class InstallationError(GenArtError):
    """A package that gen-art needs is installed in a version it cannot work with; the message names the one it needs."""

    exit_code = 2


class DivergedError(GenArtError):
    """A particle's position or velocity is no finite number any more; the message names the particle and the likely cause."""

    exit_code = 3


class AdviceWarning(UserWarning):
    """A simulation that runs, but cannot be right; the sentence says what to change."""
