"""The paper's figures and tables, done again and gone past, with its baselines."""
