"""Part II: where a vehicle should dock, after Sotiropoulos, Aspragathos & Andritsos (2011)."""
