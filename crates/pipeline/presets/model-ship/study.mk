# Flags of the stages.
# Beside the shares of time: whole maneuvers for five segments of 200 samples [1], as the random design has.
DESIGN_FLAGS = --segments 5 --segment-samples 200
