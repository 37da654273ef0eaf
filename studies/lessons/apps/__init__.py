"""The pages of the lessons, one marimo app a lesson.

A late import in a cell keeps the first page quick.
"""
