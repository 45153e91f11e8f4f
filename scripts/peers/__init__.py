"""What a practitioner would otherwise use for the same work, written as well as we know how, on one thread."""
