# Flags of the stages.
MOMENTS_FLAGS = --campaign $(STUDY)/campaign.toml --estimator output-error
DESIGN_FLAGS = --for output-error --tolerance 1e-4
ESTIMATE_FLAGS = --estimator output-error
