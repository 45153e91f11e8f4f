# Flags of this study's stages. The maneuvers are the paper's.
DICTIONARY = pipelines/scenarios/dictionary.toml
MOMENTS_FLAGS = --instruments nominal
DESIGN_FLAGS = --for iv --criterion d-hessian --segments 5 --segment-samples 200
# Every estimator on the same runs; the campaign's disturbances are what prediction-error filters with.
ESTIMATE_FLAGS = --compare --campaign $(STUDY)/campaign.toml
