"""The one exception whose text is meant for the user."""


class LingualError(Exception):
    """Something the user gave cannot be used.

    The message is one clear sentence: what is wrong, where (file, line, channel, element) and
    what to do about it. The command line prints it and exits with code 2, without a traceback.
    """
