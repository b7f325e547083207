"""Mutation testing: small mistakes put into the library, to see which its tests do not notice."""
