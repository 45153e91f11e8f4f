# Flags of this study's stages.
# Beside the shares: counts for five segments of 200 samples, the size of the random design.
DESIGN_FLAGS = --segments 5 --segment-samples 200
