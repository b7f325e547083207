"""Tests of the app in a browser, which is open while they run and not while others do."""
