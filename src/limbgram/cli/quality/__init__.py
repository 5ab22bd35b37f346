"""Commands about the quality of what was made."""
