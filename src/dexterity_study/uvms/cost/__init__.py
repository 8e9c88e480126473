"""Operations and times of exact indices and networks, Table 4 and Appendix A of paper A."""
