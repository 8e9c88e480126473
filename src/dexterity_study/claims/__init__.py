"""The claims of the papers, and the rules that judge them."""
