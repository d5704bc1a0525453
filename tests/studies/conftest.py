"""Settings of the property tests here."""

from hypothesis import settings

# how long an example takes on a busy machine says nothing
settings.register_profile("studies", deadline=None)
settings.load_profile("studies")
