# Flags of this study's stages. The maneuvers are the paper's.
DICTIONARY = pipelines/scenarios/dictionary.toml
DESIGN_FLAGS = --segments 5 --segment-samples 200
# Every estimator on the same runs; the campaign's disturbances are what prediction-error filters with.
ESTIMATE_FLAGS = --compare --campaign $(STUDY)/campaign.toml
