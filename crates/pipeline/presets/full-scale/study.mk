# Flags of the stages. `seatrial run` reads this file, and make does where the repository is at hand.
# Beside the shares of time: whole maneuvers for nine segments of 100 samples [1], as the random design has.
DESIGN_FLAGS = --segments 9 --segment-samples 100
