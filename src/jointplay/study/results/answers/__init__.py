"""What a result answers, in one to three sentences; a file a family of kinds."""
