"""Paper D: how a large flexible log crane is positioned."""
