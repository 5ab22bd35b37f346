"""Recipe: edits in order, replayed, with their ledger."""
