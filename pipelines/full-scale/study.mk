# As in the paper, one estimator for all recordings.
ESTIMATOR       := auto
# Six sub-experiments of 100 samples, as in the paper.
DESIGN_FLAGS    := --segments 6 --segment-samples 100
