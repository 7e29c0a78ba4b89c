"""What each command does; imported once its options are found to go together."""
