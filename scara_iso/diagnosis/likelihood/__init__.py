"""How likely the readings are under each hypothesis, as read on the dial."""
