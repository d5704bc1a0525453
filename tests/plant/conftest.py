"""Settings of the property tests here."""

from hypothesis import settings

# an example steps a robot many times: how long that takes on a busy machine says nothing
settings.register_profile("plant", deadline=None)
settings.load_profile("plant")
