"""Document: what every page and sheet of limbgram has in common."""
