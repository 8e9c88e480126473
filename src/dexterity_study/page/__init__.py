"""What a page shows: tables, figures, markup, footers, and how the book is built."""
