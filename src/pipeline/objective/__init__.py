"""The loss of a Reflex charge against its frequency, and the error and integral the search minimises."""
