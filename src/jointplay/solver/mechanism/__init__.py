"""What is simulated: validated, frozen records that a person can read, and what they are assembled to."""
