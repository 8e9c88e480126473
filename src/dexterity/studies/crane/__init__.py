"""Part IV: how a flexible log crane is positioned, after Rouvinen (1999)."""
