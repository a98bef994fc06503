from hypothesis import settings

# No deadline: the first example compiles. The same examples in every run: a failure in CI is one
# at home; the number of examples is what 100 s on two cores allow.
settings.register_profile("tests", deadline=None, derandomize=True, max_examples=25)
settings.load_profile("tests")
