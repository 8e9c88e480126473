"""Part IV: how a large flexible log crane is positioned, after Rouvinen (1999)."""
