"""The graph as a whole: what runs, how to start it, and how to use it."""
