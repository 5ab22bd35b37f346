"""Frame: landmarks and the limb's axes."""
