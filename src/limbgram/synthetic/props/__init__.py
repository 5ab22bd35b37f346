"""What stands and lies in the scene: the limb and its paint, boards, the room."""
