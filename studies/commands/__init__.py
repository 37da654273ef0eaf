"""The command line, one file a group of commands; nothing is computed here.

Everything heavy is imported inside the commands, so that --help answers at once.
"""
