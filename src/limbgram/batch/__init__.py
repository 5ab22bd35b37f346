"""Batch: many captures, each a case of its own, done by one command."""
