"""The apps of the lessons: controls, sentences, figures. What they show is computed in `studies.lessons`."""
