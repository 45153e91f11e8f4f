# Flags of this study's stages.
# Beside the shares: counts for five segments of 200 samples, the size of the random design.
MOMENTS_FLAGS = --instruments nominal
DESIGN_FLAGS = --for iv --criterion d-hessian --segments 5 --segment-samples 200
ESTIMATE_FLAGS = --estimator iv
