"""Lessons: a question, two or three controls, an answer computed live. `simfield teach` shows them in the browser."""
