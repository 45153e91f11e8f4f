# Six sub-experiments of 75 samples, as in the paper.
DESIGN_FLAGS    := --segments 6 --segment-samples 75
