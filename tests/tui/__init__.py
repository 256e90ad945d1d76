"""What the terminal shows and which keys do what, on an engine that a test can script."""
