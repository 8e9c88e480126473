"""The data of paper C: the worked example, the sets, and what their columns say; sections II and IV."""
