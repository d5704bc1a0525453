"""Cases for mobile arms: batches of starts, faults and goals, and how they are judged."""
