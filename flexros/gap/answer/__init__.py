"""From fits to the answer: verdict, causes, limits, patch."""
