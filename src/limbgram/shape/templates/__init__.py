"""Templates: rectifications that follow landmarks, saved or learned."""
