"""Part III: what an arm reaches, learned and exactly, after Liao & Mao (2018)."""
