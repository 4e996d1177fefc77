"""What a table is, and how it is made: its runs, their store, its JSON, its section of the page."""
