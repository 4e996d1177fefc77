"""How fast the learner is: a pytest-benchmark suite, and beside explauto."""
