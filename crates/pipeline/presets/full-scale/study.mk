# Flags of the stages.
# Beside the shares of time: whole maneuvers for nine segments of 100 samples [1], as the random design has.
DESIGN_FLAGS = --segments 9 --segment-samples 100
