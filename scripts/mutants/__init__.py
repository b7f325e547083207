"""Mutation testing: small changes to the library that its tests should notice."""
