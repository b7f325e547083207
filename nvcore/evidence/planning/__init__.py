"""How much more would it take? Power of studies like the recordings at hand, non-inferiority."""
