"""The modes of a run, one file each: how a picture of one kind is drawn, and the knob that goals turn."""
