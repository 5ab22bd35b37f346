"""Reading: limbs from files."""
