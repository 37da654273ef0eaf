"""The lessons served on this machine alone: address, token, Host and Origin are checked.

What is shown is decided in apps/.
"""
